"""The chain of skills that demonstrates a task."""

from dataclasses import replace

from roomkin.stages.config.demonstrations import DemonstrationsConfig
from roomkin.stages.plugins import load, shorten_name
from roomkin.stages.skills import Act, Outcome, SkillProtocol
from roomkin.stages.tasks.api import EnvWrapper


class SkillChain:
    """The skills that a task names, made once per task; they run one after the other."""

    def __init__(self, task: EnvWrapper, options: DemonstrationsConfig) -> None:
        self.task = task
        self.skills: list[SkillProtocol] = [load("skills", name)(task, options) for name in task.task.skills]

    def run(self, act: Act) -> Outcome:
        """Do the task from where everything stands; the first skill that fails names the cause."""
        outcome = Outcome(True, "success")
        for name, skill in zip(self.task.task.skills, self.skills, strict=True):
            outcome = skill.run(act)
            if not outcome.success:
                several = len(self.skills) > 1
                return replace(outcome, cause=f"{shorten_name(name)}_{outcome.cause}") if several else outcome
        return outcome if self.task.success else Outcome(False, "not_successful")
