"""Figures are the same whatever the user's own matplotlibrc says."""

import matplotlib

from roomkin.stages.tables.figures import style


def test_settings_of_the_user_do_not_reach_figures() -> None:
    with matplotlib.rc_context({"text.usetex": True, "savefig.bbox": "tight", "lines.linewidth": 9}), style():
        assert not matplotlib.rcParams["text.usetex"]
        assert matplotlib.rcParams["savefig.bbox"] is None
