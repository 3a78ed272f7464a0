"""docs/results/open.md from the rows of `score`."""

from collections.abc import Iterator
from pathlib import Path

import pandas as pd

from benchmarks.open_rooms.pictures import MASKS
from benchmarks.open_rooms.sureness import JUDGED, judge_sureness
from roomkin.plugins.scorecard.card import OPTIONS, share, side_of_things, table
from roomkin.plugins.scorecard.measures import FACING
from roomkin.stages.tables.intervals import pair_sides, quantiles, rate_of, resample_rates

MEASURES = ["sensible", "size", "place", "yaw", "facing", "carrier", "stable", "panels", "hinges", "handles"]
WHOLE = 0.5  # share of a thing that shows, from which on it counts as seen whole
OFF = ["depth", "width", "height", "place"]
OVERLAP = ["iou", "oriented_iou"]
FAULTS = ["held", "floats", "behind", "too_large", "carrier_wrong", "collides"]
EFFORT = ["clicks", "words", "clicks_by_hand", "words_by_hand"]
SUMMARY = ["sensible", "size", "place", "facing", "carrier", "stable"]
HALVES = {
    "work": "to work on",
    "held_out": "looked at six times",
    "third": "looked at three times",
    "fourth": "first look",
}
GIVEN = {
    "exact": "depth, exact masks, names",
    "drawn": "depth, drawn masks, names",
    "corrected": "depth, clicks",
    "unaided": "depth",
    "alone": "nothing",
}


def _summarise_plainly(rows: pd.DataFrame, measure: str) -> str:
    known = rows[measure].dropna().astype(float)
    return f"{int(known.sum())}/{len(known)}" if len(known) else ""


def fold(text: str, summary: str) -> str:
    """Markdown that is closed until its summary is clicked."""
    return f'<details markdown="1">\n<summary>{summary}</summary>\n\n{text}\n</details>\n'


def _measures(rows: pd.DataFrame) -> list[str]:
    return [share(rows, measure) for measure in MEASURES]


def scenes_of(rows: pd.DataFrame) -> pd.DataFrame:
    """Per scene what is wrong: held, floating, behind a wall, beyond twice its usual size without a doubt of it, not on
    what carries it, in one another."""
    marked = rows.assign(
        too_large=rows["too_large"] & ~rows["doubt_of_size"],
        carrier_wrong=rows["carrier"].eq(False),  # not what is unknown
        collides=rows["collides"].eq(True),
    )
    return marked.groupby(["picture", "rank"])[FAULTS].sum()


def _faults(rows: pd.DataFrame) -> list[str]:
    scenes = scenes_of(rows)
    good = int((scenes.sum(axis=1) == 0).sum())
    return [f"{good}/{len(scenes)}", *(f"{int((scenes[name] > 0).sum())}" for name in FAULTS)]


def compare_with_no_image(rows: pd.DataFrame, judge: str) -> str:
    """Chamfer distance of `no-image` less that of a judge, rank 1, over objects that both placed; in thousandths."""
    first = rows[rows["rank"] == 1]
    both = (first[first["judge"] == name] for name in ("no-image", judge))
    ours, theirs = pair_sides(*(side_of_things(one, "chamfer") for one in both))
    if ours.empty:
        return ""
    ((a, b),) = resample_rates([[ours, theirs]], OPTIONS)
    low, high = quantiles((a - b).mean(axis=1), OPTIONS)
    return f"{1000 * (rate_of(ours) - rate_of(theirs)):+.1f} [{1000 * low:+.1f}, {1000 * high:+.1f}] of {ours.shape[1]}"


def group_by_view(rows: pd.DataFrame) -> dict[str, pd.DataFrame]:
    """All things, those that the border cuts, those of which others hide more than half, and the whole ones."""
    hidden = ~rows["cut"] & (rows["seen"] < WHOLE)
    return {"all": rows, "cut": rows[rows["cut"]], "hidden": rows[hidden], "whole": rows[~rows["cut"] & ~hidden]}


def summarise(rows: pd.DataFrame) -> str:
    """Sets of rooms by what was given, rank 1, chosen by `geometry`: the table that the page begins with."""
    first = rows[(rows["rank"] == 1) & (rows["judge"] == "geometry")]
    return table(
        ["set", "given beside the picture", "things", "placed", *SUMMARY, "size, whole things", "place, whole things",
         "L2 of what is placed, mean and median (cm)", "right scenes"],
        (
            [half.replace("_", " "), given, str(len(group)), str(int((group["status"] == "ok").sum())),
             *(share(group, measure) for measure in SUMMARY),
             *(share(group_by_view(group)["whole"], measure) for measure in ("size", "place")),
             f"{group['off_place_cm'].mean():.1f}, {group['off_place_cm'].median():.1f}", _faults(group)[0]]
            for masks, given in GIVEN.items()
            for half in HALVES
            if len(group := first[(first["half"] == half) & (first["masks"] == masks)])
        ),
    )  # fmt: skip


def _describe_errors(rows: pd.DataFrame) -> list[str]:
    off = (rows[f"off_{name}_cm"].abs() for name in OFF)
    ends = (f"{each.median():.1f}, {each.quantile(0.9):.1f}" for each in off)
    overlap = (f"{rows[name].mean():.2f}, {rows[name].median():.2f}" for name in OVERLAP)
    return [*ends, f"{rows['off_place_cm'].mean():.1f}", *overlap]


def _describe_half(rows: pd.DataFrame) -> Iterator[str]:
    first = rows[rows["rank"] == 1]
    views = group_by_view(first)
    groups = [
        (masks, judge, about, views[about][(views[about]["masks"] == masks) & (views[about]["judge"] == judge)])
        for masks in MASKS
        for judge in ("geometry", "hog", "no-image")
        for about in ("all", "whole")
    ]
    yield "Rank 1, percent:\n"
    yield table(
        ["masks", "chosen by", "things", "pictures", "objects", "placed", *MEASURES, "Chamfer, thousandths"],
        (
            [
                masks, judge, about, str(group["picture"].nunique()), str(len(group)),
                str(int((group["status"] == "ok").sum())), *_measures(group), f"{1000 * group['chamfer'].mean():.1f}",
            ]
            for masks, judge, about, group in groups
            if len(group)
        ),
    )  # fmt: skip
    main = rows[(rows["masks"] == "drawn") & (rows["judge"] == "geometry")]
    yield "By rank (drawn masks, `geometry`):\n"
    yield table(
        ["rank", *MEASURES, "Chamfer, thousandths"],
        (
            [str(rank), *_measures(group), f"{1000 * group['chamfer'].mean():.1f}"]
            for rank, group in main.groupby("rank")
        ),
    )
    yield "A scene (`geometry`) is right if everything is on what carries it, nothing is in anything (5 mm), held"
    yield "in the air, floating (3 cm), behind a wall (10 cm), or beyond twice the largest of its category without a"
    yield "doubt of its size; and in how many scenes each is:\n"
    yield table(
        ["masks", "chosen by", "rank", "right", *(name.replace("_", " ") for name in FAULTS)],
        (
            [str(m), str(j), str(rank), *_faults(group)]
            for (m, j, rank), group in rows[rows["judge"] == "geometry"].groupby(["masks", "judge", "rank"])
        ),
    )
    if (blind := rows[rows["masks"].isin(rows.loc[rows["judge"] == "no-image", "masks"])]).size:
        yield "Nearer in shape than `no image`: Chamfer distance, thousandths of the diagonal (rank 1, in both):\n"
        yield table(
            ["masks", "geometry", "hog"],
            (
                [masks, compare_with_no_image(group, "geometry"), compare_with_no_image(group, "hog")]
                for masks, group in blind.groupby("masks")
            ),
        )
    yield "What is off (rank 1, `geometry`, placed objects): median, and 90 % within, cm; also the mean of place (L2);"
    yield "mean and median of both IoU with the true box:\n"
    yield table(
        ["masks", "things", "objects", *OFF, "mean L2", *OVERLAP],
        (
            [str(masks), about, str(len(group)), *_describe_errors(group)]
            for masks, mine in first[(first["judge"] == "geometry") & (first["status"] == "ok")].groupby("masks")
            for about, group in group_by_view(mine).items()
            if len(group)
        ),
    )
    best = first[(first["masks"] == "drawn") & (first["judge"] == "geometry")]
    kinds = table(
        ["kind", "objects", "placed", *MEASURES],
        (
            [str(kind).replace("_", " "), str(len(group)), str(int((group["status"] == "ok").sum())),
             *(_summarise_plainly(group, measure) for measure in MEASURES)]
            for kind, group in best.groupby("kind")
        ),
    )  # fmt: skip
    yield "By kind of thing (rank 1, drawn masks, `geometry`):\n"
    yield fold(kinds, f"{best['kind'].nunique()} kinds")


def _describe_clicks(steps: pd.DataFrame) -> Iterator[str]:
    """What correcting takes a picture, beside drawing and naming all of it; how masks and names came out."""
    pictures = steps["picture"].nunique()
    things = steps[steps["number"] > 0]
    each = steps.groupby("picture")[EFFORT].sum()
    cheaper = int((each["clicks"] < each["clicks_by_hand"]).sum())
    counts = things["mask"].value_counts().reindex(["found", "joined", "drawn"], fill_value=0)
    names = things.loc[things["mask"] != "drawn", "name"].value_counts()
    names = names.reindex(["first", "chosen", "typed"], fill_value=0)
    yield "Clicks and typed words until all things are as if drawn and named by hand, a picture (median and range):\n"
    yield table(
        ["", "clicks", "words"],
        (
            [about, *(f"{each[c].median():.0f} ({each[c].min()} to {each[c].max()})" for c in columns)]
            for about, columns in (("corrected", EFFORT[:2]), ("by hand", EFFORT[2:]))
        ),
    )
    yield (
        f"Fewer clicks than by hand in {cheaper} of {pictures} pictures. Of {len(things)} things one piece shows "
        f"{counts['found']}, several {counts['joined']}, none {counts['drawn']}. Names of those that are shown: "
        f"right at first {names['first']}, one of the other two {names['chosen']}, typed {names['typed']}. "
        f"Pieces that are no named thing, deleted: {int((steps['mask'] == 'deleted').sum())}.\n"
    )


def page(rows: pd.DataFrame, steps: pd.DataFrame) -> str:
    """The page, of open.csv.xz and clicks.csv, which may be empty."""
    numbers = [name for name in rows if name.startswith("off_")] + ["yaw_degrees"]
    rows = rows.assign(**{name: pd.to_numeric(rows[name]) for name in numbers})
    rows = rows.assign(facing=(rows["yaw_degrees"] <= FACING).where(rows["yaw"].notna()))  # wrong of what is missing
    intro = (Path(__file__).parent / "intro.md").read_text(encoding="utf-8")
    parts = [
        intro.format(
            summary=summarise(rows),
            sureness=table(["set", *JUDGED], judge_sureness(rows)),
            commit=", ".join(rows["version"].unique()),
        )
    ]
    for half, about in HALVES.items():
        mine = rows[rows["half"] == half]
        if len(mine):
            parts += [f"## {half} ({about})\n", *_describe_half(mine)]
        if len(steps) and (corrected := steps[steps["half"] == half]).size:
            parts += _describe_clicks(corrected)
    return "\n".join(parts)
