"""What tables of policies say below: what is pooled, and what policies are given that a real robot would not have."""

from stages.config.tables import PolicyTables
from stages.plugins import shorten_name
from stages.tables.methods import kind, kinds_of

SIMULATORS = {"mujoco": "MuJoCo"}  # as people write them
UNKNOWN = (
    "Policies are given the mask of the target. What else a real robot would not have (exact depth, camera poses and "
    "starts) is as the options of their rollouts say."
)


def policy_notes(options: PolicyTables) -> list[str]:
    """The notes of a run."""
    return [*_list_pooled(options), _privileged(options)]


def _list_pooled(options: PolicyTables) -> list[str]:
    """Policies of more than one hyper-parameter set."""
    kinds = kinds_of(options)
    found = [kind(name, kinds) for name, about in options.policies.items() if about.best and about.best > 1]
    if not found:
        return []
    return [
        "Runs are training seeds of one policy. Where more hyper-parameter sets were tried, those that did best in "
        f"trials on the twin, by training set, are pooled, as in the paper ({'; '.join(found)})."
    ]


def _privileged(options: PolicyTables) -> str:
    """What policies are given, as far as the run's options are known."""
    sensing = options.sensing
    if sensing is None:
        return UNKNOWN
    clean, camera = not sensing.depth_noise, not any(sensing.camera_error)
    given = ["the mask of the target", *["depth without noise"] * clean, *["exact camera poses"] * camera]
    listed = " and ".join(filter(None, [", ".join(given[:-1]), given[-1]]))
    text = f"Policies are given what a real robot would not have: {listed}, and they start within {_start(options)}."
    if not clean:
        text += " Depth has the noise of a depth camera."
    if not camera:
        metres, degrees = sensing.camera_error
        text += f" The camera is {_cm(metres)} cm and {degrees:g} degrees off the pose that they assume."
    if (name := shorten_name(sensing.simulator)) == "maniskill":
        return f"{text} Demonstrations and tests share the simulator."
    return f"{text} Demonstrations are made in ManiSkill, tests in {SIMULATORS.get(name, name)}."


def _start(options: PolicyTables) -> str:
    """How far off its place the robot stands."""
    place = "of their place before the true handle"
    if options.sensing and options.sensing.robot_init_noise:
        metres, degrees = options.sensing.robot_init_noise
        return f"{_cm(metres)} cm and {degrees:g} degrees {place}"
    return " or ".join(f"{_cm(along)} and {_cm(up)} cm" for along, up in options.starts) + f" {place}"


def _cm(metres: float) -> str:
    return f"{100 * metres:g}"
