"""The paper's claims on made-up rollouts: they hold where they should, fail where they should, else nothing is said."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from roomkin.plugins.claims import assets, claims, power
from roomkin.plugins.claims.tables import claims_table, stability_table
from roomkin.plugins.report.page.result import sentences
from roomkin.stages.config.evaluation import PolicyTables, TablesConfig
from roomkin.stages.contracts.policies import Rollout
from roomkin.stages.tables import table3
from roomkin.stages.tables.intervals import PLACE, POLICY, Side, score_interval, unit_rates
from roomkin.stages.tables.policy_tables import join_published
from roomkin.stages.tables.rows import published_policies, published_runs
from roomkin.stages.tables.text import markdown, percent
from tests.unit.tables_results import rollout

PUBLISHED = Path(__file__).resolve().parents[3] / "report" / "published"
OPTIONS = TablesConfig(bootstrap_samples=400)
ROLES = ("cousin_2", "cousin_6", "dissimilar")
STATES, ASSETS = 60, 60
Rates = dict[str, list[tuple[float, float]]]  # training set -> per run the success on the twin and on unseen assets


def rolled(rates: Rates, over: str = "test") -> list[Rollout]:
    """Rollouts with exactly these rates: states and assets are the same for all, and hard ones are hard for all."""
    order = np.random.default_rng(1).permutation(STATES)
    rows = []
    for name, runs in rates.items():
        for seed, (twin, unseen) in enumerate(runs):
            of = {"training_set": name, "seed": seed}
            rows += [rollout(n, bool(order[n] < round(twin * STATES)), **of) for n in range(STATES)]
            if over == "roles":
                opened = [bool(order[n] < round(unseen * STATES)) for n in range(STATES)]
                rows += [rollout(n, opened[n], test_asset=role, **of) for role in ROLES for n in range(STATES)]
                continue
            of["test_asset"] = over
            opened = [bool(order[n] < round(unseen * ASSETS)) for n in range(ASSETS)]
            rows += [rollout(2 * n + k, opened[n], asset=f"a_{n}", **of) for n in range(ASSETS) for k in (0, 1)]
    return rows


def papers(ours: pd.DataFrame) -> pd.DataFrame:
    """The paper's runs, beside ours."""
    return join_published(published_runs(PUBLISHED), ours, PolicyTables())


def answers(rates: Rates, over: str = "test") -> pd.DataFrame:
    frame = pd.DataFrame([row.model_dump() for row in rolled(rates, over)])
    return claims.answer(frame, papers(frame), OPTIONS).set_index("claim")


AS_PAPER: Rates = {
    "twin": [(0.95, 0.5), (0.9, 0.3), (0.95, 0.6), (0.9, 0.2), (0.95, 0.6), (0.9, 0.3)],
    "twin_randomised": [(0.95, 0.5), (0.9, 0.4)] * 3,
    "cousins_2": [(0.9, 0.9)] * 6,
    "cousins_8": [(0.95, 0.9), (0.95, 0.9), (0.95, 0.85), (0.95, 0.9), (0.95, 0.85), (0.95, 0.9)],
    "all": [(0.7, 0.6), (0.75, 0.6), (0.7, 0.5)] * 2,
}


def test_all_claims_hold_where_the_rollouts_are_like_the_papers() -> None:
    table = answers(AS_PAPER)
    assert table["verdict"].to_dict() == dict.fromkeys(claims.CLAIMS, "holds")
    assert set(table["training_set"]) == {"cousins_8"}  # most cousins
    assert table["over"].to_dict() == dict.fromkeys(claims.CLAIMS, "test") | {"equal": "twin"}
    assert table["assets"].to_dict() == dict.fromkeys(claims.CLAIMS, ASSETS) | {"equal": 1}
    mean = {name: np.mean(runs, axis=0) for name, runs in AS_PAPER.items()}
    ours, theirs = mean["cousins_8"], mean["twin"]
    assert list(table.loc["equal", ["ours", "theirs"]]) == pytest.approx([ours[0], theirs[0]], abs=0.01)
    assert table.loc["unseen", "difference"] == pytest.approx(ours[1] - theirs[1], abs=0.01)
    assert table.loc["flat", "theirs"] == pytest.approx(theirs[1] - theirs[0], abs=0.01)  # what the twin loses
    spread = -np.sqrt(np.var(AS_PAPER["twin"], axis=0, ddof=1).mean())
    assert table.loc["steady", "theirs"] == pytest.approx(spread, abs=0.01)
    assert table.loc["all", "theirs"] == pytest.approx(mean["all"][1], abs=0.01)
    assert table.loc["all", "baseline"] == "all"
    assert (table["low"] < table["difference"]).all() and (table["difference"] < table["high"]).all()


def test_a_claim_over_unseen_assets_has_the_interval_of_their_table() -> None:
    rows = pd.DataFrame([row.model_dump() for row in rolled(AS_PAPER)])
    shown = assets.build(rows, OPTIONS, {}).set_index("training_set").loc["cousins_8"]
    table = answers(AS_PAPER)
    for claim, name in (("unseen", "twin"), ("randomised", "randomised")):
        assert list(table.loc[claim, ["low", "high"]]) == list(shown[[f"{name}_low", f"{name}_high"]])


def test_over_the_roles_alone_nothing_is_said_of_other_assets() -> None:
    """Three assets are too few, however many states and runs there are."""
    table = answers(AS_PAPER, "roles")
    assert table["over"]["unseen"] == "roles" and table["assets"]["unseen"] == 3
    open_claims = {"unseen", "flat", "all"}
    assert {name for name, verdict in table["verdict"].items() if verdict == "too few assets to decide"} >= open_claims
    shown = table["shows"]
    assert not (shown[["unseen", "flat", "all"]] <= 0.6).any()  # a gain of 60 points on each would not do
    assert shown["equal"] == 0  # sixty starts do
    assert answers(AS_PAPER, "validation")["verdict"]["unseen"] == "holds"


def sides_of(assets: int, states: int, runs: int = 6) -> claims.Sides:
    """Policies and places of the twin and of so many unseen assets, a family each."""
    policies = pd.MultiIndex.from_tuples([("lite", seed, "last") for seed in range(runs)], names=POLICY)

    def side(count: int) -> Side:
        places = [(f"f{n}", f"a{n}", k) for n in range(count) for k in range(states)]
        return pd.DataFrame(0.0, policies, pd.MultiIndex.from_tuples(places, names=PLACE))

    return {"twin": side(1), "unseen": side(assets)}


@pytest.mark.parametrize(
    ("claim", "assets", "states", "least"),
    [("unseen", 3, 25, 0.7), ("unseen", 40, 2, 0.2), ("flat", 3, 25, 0.7), ("equal", 3, 25, 1), ("equal", 3, 60, 0)],
)
def test_what_a_claim_can_show_is_known_beforehand(claim: str, assets: int, states: int, least: float) -> None:
    """Three assets show no gain but of 70 points and more, forty one of 20; 25 starts never show `as well as`."""
    sides = sides_of(assets, states)
    shown = claims.find_shown(claim, sides, sides, OPTIONS)
    assert np.isnan(shown) or shown >= least if assets == 3 and least else shown <= least + 0.1


def test_what_can_be_shown_is_shown_and_where_nothing_is_there_nothing_holds() -> None:
    """Verdicts on made-up results of known truths: a gain of half holds, none holds once in twenty at most."""
    sides, rng = sides_of(30, 2), np.random.default_rng(3)
    said = {
        effect: [
            claims.compare("unseen", *power.imagine(sides, sides, "unseen", effect, rng), OPTIONS)["verdict"]
            for _ in range(40)
        ]
        for effect in (0.0, 0.5)
    }
    assert said[0.5].count("holds") >= 36
    assert said[0.0].count("holds") <= 2 and said[0.0].count("does not hold") <= 2


def test_all_claims_fail_where_the_rollouts_say_the_opposite() -> None:
    worse: Rates = {
        "twin": [(0.95, 0.95)] * 6,
        "twin_randomised": [(0.95, 0.9)] * 6,
        "cousins_8": [(0.6, 0.2), (0.5, 0.1), (0.7, 0.4)] * 2,
        "all": [(0.9, 0.9)] * 6,
    }
    assert answers(worse)["verdict"].to_dict() == dict.fromkeys(claims.CLAIMS, "does not hold")


def test_nothing_is_said_where_training_sets_are_alike_or_runs_too_few() -> None:
    alike: Rates = {name: [(0.5, 0.5), (0.6, 0.5), (0.4, 0.6)] * 2 for name in AS_PAPER}
    table = answers(alike)
    assert set(table["verdict"]) == {"cannot be said"}
    assert (table["low"] <= 0).all() and (table["high"] >= 0).all()
    one = answers({name: runs[:1] for name, runs in AS_PAPER.items()})
    assert set(one["verdict"]) == {"cannot be said"} and np.isnan(one.loc["steady", "low"])
    means = one.drop("steady")  # the intervals of these policies are told all the same
    assert (means["low"] < means["difference"]).all() and (means["difference"] < means["high"]).all()
    two = answers({name: runs[:2] for name, runs in AS_PAPER.items()})["verdict"].to_dict()
    assert two["unseen"] == "holds" and two["steady"] == "cannot be said"


def test_a_claim_needs_its_training_sets() -> None:
    assert list(answers({"twin": AS_PAPER["twin"], "cousins_2": AS_PAPER["cousins_2"]}).index) == [
        "equal", "unseen", "flat", "steady",
    ]  # fmt: skip
    assert answers({"twin": AS_PAPER["twin"], "all": AS_PAPER["all"]}).empty


def test_as_well_as_the_twin_allows_ten_points() -> None:
    equal = claims.CLAIMS["equal"]
    ends = ((-0.09, 0.02), (-0.2, 0.1), (-0.2, -0.05), (-0.3, -0.11))
    assert [claims.judge_claim(equal, low, high, 6) for low, high in ends] == [
        "holds", "cannot be said", "cannot be said", "does not hold",
    ]  # fmt: skip
    unseen = claims.CLAIMS["unseen"]
    assert [claims.judge_claim(unseen, low, high, 6) for low, high in ((0.01, 0.3), (-0.01, 0.3), (-0.3, -0.01))] == [
        "holds", "cannot be said", "does not hold",
    ]  # fmt: skip


def test_the_floor_of_what_is_lost_is_wide_where_the_rates_may_be() -> None:
    """All of 30 on the twin, 3 of 30 unseen assets: the truth may lie above the second, not above the first."""
    places = pd.MultiIndex.from_tuples([(f"f{n}", f"a{n}", 0) for n in range(30)], names=PLACE)

    def side(opened: int) -> Side:
        return pd.DataFrame([[float(n < opened) for n in range(30)]], columns=places)

    ours, theirs = {"twin": side(30), "unseen": side(3)}, {"twin": side(3), "unseen": side(3)}
    unseen, twin = (
        score_interval(unit_rates(ours[name]), unit_rates(theirs[name]), 0.95) for name in ("unseen", "twin")
    )
    low, high = claims.score_floor(claims.CLAIMS["flat"], ours, theirs, 0.95)
    assert low == pytest.approx(-0.9 - np.hypot(unseen.low, twin.high - 0.9))
    assert high == pytest.approx(-0.9 + np.hypot(unseen.high, 0.9 - twin.low))
    assert high + 0.9 > 1.1 * (-0.9 - low)


def test_the_papers_own_numbers_stand_beside_ours() -> None:
    table = answers(AS_PAPER)
    assert list(table.loc["equal", ["published_ours", "published_theirs"]]) == pytest.approx([0.9317, 0.9], abs=1e-3)
    paper = table["published_difference"]  # in the paper all five hold for doors; it has no randomised twin
    assert (paper.drop("randomised") > 0).all() and pd.isna(paper["randomised"])
    shown = claims_table(table.reset_index(), OPTIONS)
    assert shown.rows[1][1] == (
        "On unseen assets, policies trained on 8 cousins do better than those trained on the twin"
    )
    assert "\n95 % against 92 %\n" in shown.rows[0][3] and "paper" in markdown(shown)
    few = claims_table(answers({name: runs[:1] for name, runs in AS_PAPER.items()}).reset_index(), OPTIONS)
    assert few.rows[0][2] == "cannot be said\n1 run a side, 2 needed to judge"
    steady = next(row for row in few.rows if "differ less" in row[1])
    assert steady[3].startswith("–") and "nan" not in markdown(few)


def test_the_headline_gives_the_numbers_of_one_seed_and_says_what_they_are() -> None:
    one = answers({name: runs[:1] for name, runs in AS_PAPER.items()}).reset_index()
    line, (again,) = sentences(one, "door", {"lite": "lite"})
    row = one[one["claim"] == "unseen"].iloc[0]
    assert line.startswith("Door opening on ") and line.endswith(
        "1 training a side, and another may turn out otherwise"
    )
    assert (
        f" succeeds {percent(row['ours'])} of the time after training on 8 cousins, {percent(row['theirs'])} " in line
    )
    assert "training again: set <code>experiment: {seeds: [0, 1]}" in again
    _, (judged,) = sentences(answers(AS_PAPER).reset_index(), "door", {"lite": "lite"})
    assert judged.endswith("over 6 and 6 seeds of training: that cousins help holds.")
    assert sentences(None, "door", {}) == ("", []) == sentences(one, "door", {"other": "lite"})


def build(rows: list[Rollout]) -> pd.DataFrame:
    frame = pd.DataFrame([row.model_dump() for row in rows])
    return table3.build(frame, join_published(published_policies(PUBLISHED), frame, PolicyTables()), OPTIONS)


def test_collapsed_runs_are_counted_on_the_assets_of_the_training() -> None:
    rows = rolled({"twin": [(0.9, 0), (0.1, 0.3)], "cousins_4": [(0.1, 0.4)]}, "roles")
    published = papers(pd.DataFrame([row.model_dump() for row in rows]))
    table = claims.stability(build(rows), published).set_index("training_set")
    assert table["collapsed"].to_dict() == {"twin": 1, "cousins_4": 1}  # on the twin, for want of anything better
    assert table.loc["twin", "spread"] == pytest.approx(np.sqrt((0.8**2 + 3 * 0.3**2) / 2 / 4))
    for name, seed, good in (("twin", 0, 54), ("twin", 1, 6), ("cousins_4", 0, 45)):
        rows += [rollout(n, n < good, training_set=name, seed=seed, test_asset="trained") for n in range(STATES)]
    assert table["spread"].isna().tolist() == [False, True]
    table = claims.stability(build(rows), published)
    assert table.set_index("training_set")["collapsed"].to_dict() == {"twin": 1, "cousins_4": 0}
    assert "1 of 2" in markdown(stability_table(table))


def test_a_run_is_collapsed_beside_the_best_of_its_task_however_good_that_is() -> None:
    gates = {"twin": np.array([0.4, 0.15]), "cousins_4": np.array([0.08, 0.12])}
    assert claims._count_collapsed(gates) == {"twin": 0, "cousins_4": 1}  # a quarter of 40 %


def test_six_drawer_policies_of_the_paper_collapsed() -> None:
    cells = claims.published_cells(papers(pd.DataFrame([rollout().model_dump()])))
    drawer = {name: rates["twin"] for (target, _, name), rates in cells.items() if target == "drawer"}
    assert claims._count_collapsed(drawer) == {"twin": 1, "cousins_2": 1, "cousins_4": 2, "cousins_8": 0, "all": 2}
