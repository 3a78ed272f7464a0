"""The client of a language model against a server that speaks its protocol, with all that can go wrong; the ledger."""

import json
import time
from multiprocessing import get_context
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from openai._base_client import SyncAPIClient
from pydantic import BaseModel, ConfigDict, ValidationError

from roomkin.plugins.vlm.ask import Asker, NoAnswerError
from roomkin.plugins.vlm.endpoint import Ledger
from roomkin.plugins.vlm.package import VlmConfig
from roomkin.plugins.vlm.prompt import Prompt, data_url
from roomkin.plugins.vlm.tests.chat_server import (
    KEY,
    Step,
    chooses,
    fails,
    hangs_up,
    only,
    pictures,
    reply,
    says,
    sends,
    serving,
    sleeps,
)
from roomkin.stages.contracts import InputError
from tests.refusals import refused


class Choice(BaseModel):
    model_config = ConfigDict(extra="forbid")
    reason: str
    choice: Literal["1", "2", "none"]


PICTURE = np.arange(40 * 60 * 3, dtype=np.uint8).reshape(40, 60, 3)
PROMPT = Prompt("You compare furniture.", ["The object:", PICTURE, "Candidate 1:", 255 - PICTURE, "Answer in JSON."])
NAMES = {"1": "chair_1", "2": "chair_2"}


@pytest.fixture(autouse=True)
def _without_pauses(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("no_proxy", "127.0.0.1")
    monkeypatch.setattr(SyncAPIClient, "_sleep_for_retry", lambda *_, **__: None)


def asker(folder: Path, url: str, **options: Any) -> Asker:
    given = {"url": url, "model": "toy", "key_env": "", "ledger": str(folder / "ledger"), "timeout": 5} | options
    return Asker(VlmConfig(**given))


def ask(asker: Asker, prompt: Prompt = PROMPT) -> str:
    return asker.ask(prompt, Choice, "room_1/chair_1: model", NAMES).choice


def entries(folder: Path) -> list[dict[str, Any]]:
    return [json.loads(path.read_text()) for path in sorted((folder / "ledger").glob("*.json"))]


def test_an_answer_is_paid_for_once(tmp_path: Path) -> None:
    with serving(chooses("2")) as server:
        first, second = asker(tmp_path, server.url), asker(tmp_path, server.url)
        assert ask(first) == ask(first) == ask(second) == "2"
        assert len(server.requests) == 1
        body = server.requests[0]
    assert body["temperature"] == 0 and body["response_format"]["type"] == "json_schema"
    assert np.array_equal(pictures(body)[0], PICTURE) and len(pictures(body)) == 2
    (entry,) = entries(tmp_path)
    assert entry["cost"] == pytest.approx((1000 * 2.5 + 20 * 10) / 1e6) and entry["names"] == NAMES
    assert entry["exchanges"][0]["served_by"] == "toy-2026" and "base64" not in json.dumps(entry)
    assert first.summary() == "toy: 1 answers from the ledger, 1 asked for; the ledger has 1 requests for 0.0027"


def test_a_run_replays_without_key_and_network_and_says_what_is_missing(tmp_path: Path) -> None:
    with serving(chooses("1")) as server:
        ask(asker(tmp_path, server.url))
    replay = asker(tmp_path, "http://127.0.0.1:9/v1", mode="replay", key_env="NO_SUCH_KEY")
    assert ask(replay) == "1"
    changed = PICTURE.copy()
    changed[0, 0, 0] += 1
    for prompt in (PROMPT._replace(system="Otherwise."), PROMPT._replace(parts=["The object:", changed])):
        with refused("E-VLM-REPLAY"):
            ask(replay, prompt)
    with refused("E-VLM-REPLAY"):
        ask(asker(tmp_path, "http://127.0.0.1:9/v1", mode="replay", model="another"))
    with refused("E-VLM-REPLAY"):
        ask(asker(tmp_path, "http://127.0.0.1:9/v1", mode="replay", options={"temperature": 1}))


BAD: dict[str, Step] = {
    "lies": chooses("7"),
    "empty": says(""),
    "nothing": says(None),
    "cut off": chooses("1", finish="length"),
    "filtered": chooses("1", finish="content_filter"),
    "declines": says(None, refusal="I cannot"),
    "no json": says("The second one."),
    "half": says('{"reason": "it lo'),
    "more keys": says('{"reason": "", "choice": "1", "sure": true}'),
    "wrong type": says('{"reason": "", "choice": 1}'),
    "a list": says('["1"]'),
    "long": says(json.dumps({"reason": "x" * 30_000, "choice": "1"})),
    "a page": sends(b"<html>Bad gateway</html>"),
    "an array": sends(b"[]"),
    "no choice": sends(json.dumps({"choices": []}).encode()),
    "odd": sends(json.dumps({"choices": [{"message": "hello"}]}).encode()),
}


@pytest.mark.parametrize("bad", BAD)
def test_a_bad_answer_is_asked_again_a_few_times_and_never_invented(tmp_path: Path, bad: str) -> None:
    with serving(BAD[bad], chooses("2")) as server:
        assert ask(asker(tmp_path / "once", server.url)) == "2"
        again = server.requests[1]["messages"]
        assert [message["role"] for message in again] == ["system", "user", "assistant", "user"]
        assert "cannot be used" in again[-1]["content"] and len(again[-2]["content"]) <= 500
        assert entries(tmp_path / "once")[0]["cost"] > 0.003  # both were paid for
    with serving(BAD[bad]) as server:
        for _ in range(2):
            with pytest.raises(NoAnswerError):
                ask(asker(tmp_path, server.url))
        assert len(server.requests) == 3  # the second time the ledger knows
    with pytest.raises(NoAnswerError):
        ask(asker(tmp_path, server.url, mode="replay"))


@pytest.mark.parametrize(
    "text",
    [
        '```json\n{"reason": "", "choice": "1"}\n```',
        '<think>{"choice": "2"}?</think> {"reason": "{}", "choice": "1"}',
        [{"type": "text", "text": '{"reason": "", '}, {"type": "text", "text": '"choice": "1"}'}],
    ],
)
def test_json_is_found_in_what_models_write_around_it(tmp_path: Path, text: Any) -> None:
    with serving(says(text)) as server:
        assert ask(asker(tmp_path, server.url)) == "1" and len(server.requests) == 1


@pytest.mark.parametrize("kind", ["json_object", None])
def test_a_server_without_schemas_is_asked_otherwise(tmp_path: Path, kind: str | None) -> None:
    with serving(only(kind, chooses("2"))) as server:
        one = asker(tmp_path, server.url)
        assert ask(one) == ask(one, PROMPT._replace(system="Again.")) == "2"
        asked = [body.get("response_format", {}).get("type") for body in server.requests]
    tried = ["json_schema", "json_object", None]
    assert asked == [*tried[: tried.index(kind) + 1], kind]  # what it takes is remembered


@pytest.mark.parametrize("busy", [fails(429), fails(500), fails(503), hangs_up, sleeps(1.0)])
def test_a_busy_server_is_waited_for(tmp_path: Path, busy: Step) -> None:
    with serving(busy, chooses("1")) as server:
        assert ask(asker(tmp_path, server.url, timeout=0.3)) == "1"
    assert entries(tmp_path)[0]["exchanges"][0]["requests"] == 2


@pytest.mark.parametrize(
    "change",
    [
        {"model": "\ud800"},
        {"model": {"name": "toy"}},
        {"usage": {"prompt_tokens": 10**30, "completion_tokens": 10**9 + 1}},
        {"usage": {"prompt_tokens": 1.5, "completion_tokens": True}},
        {"choices": [{"message": {"content": '{"reason": "\ud83d", "choice": "1"}'}}]},
        {"choices": [{"message": {"content": [{"text": 3}, {"text": '{"reason": "", "choice": "1"}'}]}}]},
    ],
    ids=["half a character", "no text", "many tokens", "odd tokens", "half in the answer", "odd parts"],
)
def test_no_odd_reply_costs_its_entry(tmp_path: Path, change: dict[str, Any]) -> None:
    content = reply('{"reason": "it looks like it", "choice": "1"}') | change
    with serving(sends(json.dumps(content).encode())) as server:
        assert ask(asker(tmp_path, server.url)) == "1"
    (entry,) = entries(tmp_path)
    assert entry["outcome"] == "answered" and entry["cost"] < 0.1


def test_a_server_that_stays_silent_gives_no_answer_and_is_asked_again_another_time(tmp_path: Path) -> None:
    with serving(fails(500, "down")) as server:
        one = asker(tmp_path, server.url)
        with pytest.raises(NoAnswerError, match="HTTP 500: down"):
            ask(one)
        with pytest.raises(NoAnswerError):  # a replay is what the run was
            ask(asker(tmp_path, server.url, mode="replay"))
        for word, error in (("b", NoAnswerError), ("c", InputError)):  # the third in a row
            with pytest.raises(error):
                ask(one, PROMPT._replace(system=word))
        server.steps = [chooses("2")]
        assert ask(one) == "2"
        assert sum(entry["outcome"] == "answered" for entry in entries(tmp_path)) == 1
        assert one.ledger.sum_costs().requests == 16


@pytest.mark.parametrize(
    ("step", "code"),
    [
        (fails(404, "no model toy"), "E-VLM-ADDRESS"),
        (fails(403), "E-VLM-KEY"),
        (fails(429, "insufficient_quota: pay"), "E-VLM-ACCOUNT"),
        (fails(400, "unknown option max_tokens"), "E-VLM-REQUEST"),
        (fails(307, Location="http://127.0.0.1:9/v1"), "E-VLM-ADDRESS"),
    ],
)
def test_what_waiting_does_not_mend_stops_the_job(tmp_path: Path, step: Step, code: str) -> None:
    with serving(step) as server, refused(code):
        ask(asker(tmp_path, server.url))
    assert not entries(tmp_path)


def test_a_question_that_a_filter_takes_has_no_answer(tmp_path: Path) -> None:
    with serving(fails(400, "content_filter")) as server, pytest.raises(NoAnswerError, match="filter"):
        ask(asker(tmp_path, server.url))


def test_a_key_that_is_missing_or_wrong_stops_the_job(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with serving(chooses("1"), key=KEY) as server:
        for given in ("", " ", "not a\nkey", "another-key"):
            monkeypatch.setenv("TOY_KEY", given)
            with refused("E-VLM-KEY") as error:
                ask(asker(tmp_path, server.url, key_env="TOY_KEY"))
            assert not given.strip() or given not in str(error.value)
        monkeypatch.setenv("TOY_KEY", KEY)
        assert ask(asker(tmp_path, server.url, key_env="TOY_KEY")) == "1"
    with pytest.raises(ValidationError, match="belongs into the environment"):
        VlmConfig(url="https://me:secret@example.org/v1")


ESCAPED = "".join(f"\\u{ord(letter):04x}" for letter in KEY)
REPEATS: dict[str, Step] = {
    "a reason": says(json.dumps({"reason": f"your key is {KEY}", "choice": "1"})),
    "a reason, escaped": says(f'{{"reason": "{ESCAPED}", "choice": "1"}}'),
    "a field": says(json.dumps({"reason": "", "choice": "1", KEY: "1"})),
    "a field, escaped": says(f'{{"reason": "", "choice": "1", "{ESCAPED}": 1}}'),
    "no JSON": says(f"What is {KEY}?"),
    "the model": sends(json.dumps(reply('{"reason": "", "choice": "1"}') | {"model": KEY}).encode()),
    "a refusal": fails(400, f"no such option: {KEY}"),
    "an error": fails(500, f"bad: {KEY}"),
    "an error without JSON": lambda handler, body: handler.send(502, f"<p>{KEY}</p>".encode()),
    "no such page": fails(404, KEY),
    "a redirect": fails(307, KEY, Location=f"http://127.0.0.1:9/{KEY}"),
    "the status line": lambda handler, body: handler.wfile.write(f"HTTP/1.1 {KEY}\r\n\r\n".encode()),
}


@pytest.mark.parametrize("place", REPEATS)
def test_a_key_that_the_server_repeats_is_written_nowhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str], place: str
) -> None:
    monkeypatch.setenv("TOY_KEY", KEY)
    with serving(REPEATS[place], key=KEY) as server:
        try:
            said = ask(one := asker(tmp_path, server.url, key_env="TOY_KEY")) + one.summary()
        except (NoAnswerError, InputError) as error:
            said = str(error)
    said += "".join(capfd.readouterr()) + "".join(path.read_text() for path in tmp_path.rglob("*.json"))
    assert KEY not in said and ESCAPED not in said and ESCAPED.replace("\\", "\\\\") not in said


def test_what_a_server_says_steers_no_terminal(tmp_path: Path) -> None:
    evil = "\x1b]0;pwned\x07\x1b[2J\u202e"
    for step in (fails(500, evil), fails(400, evil), says(json.dumps({"reason": "", "choice": "1", evil: "1"}))):
        with serving(step) as server, pytest.raises((NoAnswerError, InputError)) as caught:
            ask(asker(tmp_path / str(id(step)), server.url))
        assert str(caught.value).isprintable() and "pwned" in str(caught.value)


def test_the_budget_holds_for_the_whole_ledger(tmp_path: Path) -> None:
    prompts = [PROMPT._replace(system=word) for word in "abcd"]
    with serving(chooses("1")) as server:
        ask(asker(tmp_path, server.url), prompts[0])
        with refused("E-VLM-BUDGET"):
            ask(asker(tmp_path, server.url, max_calls=1), prompts[1])
        one = asker(tmp_path, server.url, max_cost=0.015)
        ask(one, prompts[1])  # 0.0027 each, and up to 0.0101 for one with the longest answer
        with refused("E-VLM-BUDGET"):
            ask(one, prompts[2])
        assert ask(one, prompts[0]) == "1"  # what is known costs nothing
        assert len(server.requests) == 2
        server.steps = [chooses("9")]
        with refused("E-VLM-BUDGET"):  # between an answer and the next try
            ask(asker(tmp_path, server.url, max_calls=3), prompts[3])
        server.steps = [chooses("2")]
        with refused("E-VLM-REPLAY"):  # it was stopped: no abstention
            ask(asker(tmp_path, server.url, mode="replay"), prompts[3])
        assert ask(asker(tmp_path, server.url), prompts[3]) == "2"
        assert Ledger(tmp_path / "ledger").sum_costs() == (4, pytest.approx(4 * 0.0027))


def test_tokens_that_are_not_counted_are_estimated(tmp_path: Path) -> None:
    with serving(chooses("1", usage=None)) as server:
        ask(asker(tmp_path, server.url))
    (exchange,) = entries(tmp_path)[0]["exchanges"]
    assert 2000 < exchange["tokens_in"] < 2100 and exchange["estimated"]


def test_two_jobs_do_not_ask_the_same_at_once(tmp_path: Path) -> None:
    def slow(handler: Any, body: dict[str, Any]) -> None:
        time.sleep(0.2)
        chooses("1")(handler, body)

    with serving(slow) as server:
        jobs = [get_context("fork").Process(target=ask, args=(asker(tmp_path, server.url),)) for _ in range(2)]
        for job in jobs:
            job.start()
        for job in jobs:
            job.join(20)
        assert [job.exitcode for job in jobs] == [0, 0] and len(server.requests) == 1


def test_a_damaged_entry_is_named(tmp_path: Path) -> None:
    with serving(chooses("1")) as server:
        ask(asker(tmp_path, server.url))
        path = next((tmp_path / "ledger").glob("*.json"))
        text = path.read_text()
        for wrong in (
            text[:100],
            text.replace('"key": "', '"key": "0'),
            text.replace('"choice": "1"', '"choice": "8"'),
        ):
            path.write_text(wrong)
            with pytest.raises(InputError, match="delete the file"):
                ask(asker(tmp_path, server.url))


def test_an_option_can_be_taken_out(tmp_path: Path) -> None:
    with serving(chooses("1")) as server:
        ask(asker(tmp_path, server.url, options={"max_tokens": None, "max_completion_tokens": 90}))
        assert "max_tokens" not in server.requests[0] and server.requests[0]["max_completion_tokens"] == 90


def test_pictures_are_reduced(tmp_path: Path) -> None:
    with serving(chooses("1")) as server:
        ask(asker(tmp_path, server.url, image_size=32))
        assert pictures(server.requests[0])[0].shape == (21, 32, 3)
    assert data_url(PICTURE, 60) == data_url(PICTURE, 600)


@pytest.mark.parametrize(
    "wrong", [{"url": "ftp://host"}, {"url": "http://"}, {"options": {"model": "x"}}, {"key_env": "sk-1"}]
)
def test_options_that_cannot_be(wrong: dict[str, Any]) -> None:
    with pytest.raises(ValidationError):
        VlmConfig(**wrong)
