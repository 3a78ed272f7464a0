"""Ask a language model: out of the ledger if it is there, else over the network, within the budget."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from roomkin.plugins.vlm.endpoint import (
    AGAIN,
    MAX_QUOTED,
    Endpoint,
    Entry,
    Exchange,
    Ledger,
    RefusedRequestError,
    UnreachedError,
)
from roomkin.plugins.vlm.package import VlmConfig
from roomkin.plugins.vlm.prompt import (
    DETAIL,
    LONGEST,
    TOKENS,
    Prompt,
    UnusableError,
    digest,
    parse_answer,
    response_format,
    text_of,
    usage_of,
)
from roomkin.stages.contracts.errors import InputError

A = TypeVar("A", bound=BaseModel)
FORMATS = ("json_schema", "json_object", "words")  # the next where a server refuses one
REASKS = 2  # after answers that cannot be used
SILENCES = 3  # questions in a row without a reply: then the server is taken to be down
RAISE = "raise it; what was answered stays in the ledger"
FILTERED = ("content_filter", "content_policy")


class NoAnswerError(Exception):
    """The model gave no answer that can be used; the text says why."""


class Asker:
    """One model behind one ledger."""

    def __init__(self, options: VlmConfig) -> None:
        self.options = options
        self.ledger = Ledger(Path(options.ledger))
        self.endpoint = Endpoint(options, self._count_request)
        self.asked, self.known = 0, 0  # questions of this process: over the network, out of the ledger
        self._format = 0
        self._silences = 0
        self._sent, self._size = 0, 0  # requests of the exchange at hand, which the ledger lacks yet; tokens of each

    def ask(
        self,
        prompt: Prompt,
        answer: type[A],
        about: str = "",
        names: dict[str, str] | None = None,
        stand_in: tuple[str, Callable[[], A]] | None = None,
    ) -> A:
        """The checked answer to a question.

        Args:
            prompt: what is asked.
            answer: what must come back; its JSON schema goes along.
            about: what the question is about, for readers of the ledger.
            names: what the choices stand for, likewise.
            stand_in: name of who answers in the model's place, and the answer.

        Raises:
            NoAnswerError: there is none that can be used; the ledger knows that, too.
            InputError: nobody can be asked (key, address, budget), or the ledger lacks the call and is only replayed.
        """
        options = self.options
        settings = {"options": options.options, "detail": DETAIL, "size": options.image_size}
        question = prompt.digest()
        model = stand_in[0] if stand_in else options.model
        key = digest({"model": model, "settings": settings, "question": question})
        if options.mode == "replay":
            known = self.ledger.find(key)
            if known is None or known.outcome == "open":
                what = f"lacks a call to {model} about {about or key}."
                raise InputError(self.ledger.folder, what, "vlm.mode: record asks it", code="E-VLM-REPLAY")
            self.known += 1
            return answer_of(known, answer)
        with self.ledger.lock_key(key):
            known = self.ledger.find(key)
            if known is not None and known.outcome in ("answered", "unusable"):
                self.known += 1
                return answer_of(known, answer)
            entry = Entry(
                key=key, question=question, model=model, settings=settings, about=about, names=names or {},
                asked=prompt.as_record(), exchanges=known.exchanges if known else [], outcome="open",
                cost=known.cost if known else 0,
            )  # fmt: skip
            self.asked += 1
            if stand_in:
                value = stand_in[1]()
                entry.outcome, entry.answer = "answered", value.model_dump(mode="json")
                self.ledger.write(entry)
                return value
            self._ask_until_valid(entry, prompt, answer)
        self._silences = self._silences + 1 if entry.outcome == "unreached" else 0
        if self._silences >= SILENCES:
            what = f"does not answer ({entry.problem})."
            raise InputError(options.url, what, "try again later, what is known stays", code="E-VLM-SILENT")
        return answer_of(entry, answer)

    def summary(self, who: str = "") -> str:
        """Counts of this process's questions and the cost of the whole ledger, in one line; `who`: not the model."""
        spent = self.ledger.sum_costs()
        return (
            f"{who or self.options.model}: {self.known} answers from the ledger, {self.asked} asked for; "
            f"the ledger has {spent.requests} requests for {spent.cost:.4f}"
        )

    def _ask_until_valid(self, entry: Entry, prompt: Prompt, answer: type[A]) -> None:
        """Ask, and ask again after a bad answer; the ledger has every exchange before the next one begins."""
        messages = prompt.messages(self.options.image_size)
        for left in range(REASKS, -1, -1):
            try:
                exchange, value = self._exchange(messages, answer, prompt.tokens())
            except UnreachedError as error:
                exchange, value = Exchange(requests=self._sent, problem=str(error) or "no reply"), None
                entry.outcome = "unreached"
            entry.exchanges.append(exchange)
            entry.cost += self._cost(exchange.tokens_in, exchange.tokens_out)
            if value is not None:
                entry.outcome, entry.answer = "answered", value.model_dump(mode="json")
            elif not left and entry.outcome == "open":
                entry.outcome = "unusable"
            self.ledger.write(entry)
            if entry.outcome != "open":
                return
            again = f"This cannot be used: {exchange.problem}. Answer with nothing but the JSON object asked for."
            before = exchange.text[:MAX_QUOTED] or "(nothing)"
            messages = [*messages, {"role": "assistant", "content": before}, {"role": "user", "content": again}]

    def _exchange(self, messages: list[dict[str, Any]], answer: type[A], size: int) -> tuple[Exchange, A | None]:
        """One request that is replied to, and the answer if it can be used."""
        self._sent, self._size = 0, size
        text, value, problem = "", None, ""
        reply: dict[str, Any] = {}
        try:
            reply = self._reply(messages, answer)
            text = self.endpoint.hide_key(text_of(reply))
            value = parse_answer(text, answer)
        except UnusableError as error:
            problem = self.endpoint.quote_server(str(error))
        usage, served = usage_of(reply), reply.get("model")
        served = served if isinstance(served, str) else ""
        tokens_in, tokens_out = usage or (size, len(text) // 3)
        exchange = Exchange(
            requests=self._sent, text=text[:LONGEST], problem=problem, served_by=self.endpoint.hide_key(served)[:100],
            tokens_in=tokens_in, tokens_out=tokens_out, estimated=usage is None,
        )  # fmt: skip
        return exchange, value

    def _reply(self, messages: list[dict[str, Any]], answer: type[A]) -> dict[str, Any]:
        """The reply in the strictest format that the server takes."""
        refusal = ""
        for number in range(self._format, len(FORMATS)):
            body = {"model": self.options.model, "messages": messages, **self.options.options}
            if form := response_format(FORMATS[number], answer):
                body["response_format"] = form
            try:
                reply = self.endpoint.post(body)
            except RefusedRequestError as error:
                if any(word in str(error) for word in FILTERED):
                    raise UnusableError("the server's filter took the question") from None
                refusal = refusal or str(error)  # of the strictest format
                continue
            self._format = number
            return reply
        mend = "correct vlm.model or vlm.options, or lower vlm.image_size"
        raise InputError(self.options.url, f"refuses the request ({refusal}).", mend, code="E-VLM-REQUEST")

    def _count_request(self) -> None:
        """Count a request, if the budget has one left."""
        options, spent = self.options, self.ledger.sum_costs()
        if options.max_calls is not None and spent.requests + self._sent >= options.max_calls:
            what = f"{options.max_calls} requests are used up."
            raise InputError("vlm.max_calls", what, RAISE, code="E-VLM-BUDGET")
        given = options.options
        longest = given.get("max_tokens") or given.get("max_completion_tokens") or TOKENS
        next_one = self._cost(self._size, longest if isinstance(longest, int) else TOKENS)
        if options.max_cost is not None and spent.cost + next_one > options.max_cost:
            what = f"{spent.cost:.4f} of {options.max_cost:g} are spent, and the next request may cost {next_one:.4f}."
            raise InputError("vlm.max_cost", what, RAISE, code="E-VLM-BUDGET")
        self._sent += 1

    def _cost(self, sent: int, received: int) -> float:
        """Price of so many tokens."""
        return (sent * self.options.price_input + received * self.options.price_output) / 1e6


def answer_of(entry: Entry, answer: type[A]) -> A:
    """The answer that an entry of the ledger holds.

    Raises:
        NoAnswerError: it holds none.
    """
    if entry.outcome != "answered":
        raise NoAnswerError(entry.problem or "no answer")
    try:
        return answer.model_validate(entry.answer)
    except ValidationError:
        what = "of the ledger holds another kind of answer."
        raise InputError(f"{entry.key}.json", what, AGAIN, code="E-VLM-LEDGER") from None
