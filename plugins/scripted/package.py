"""The package as the core knows it."""

from stages.config.evaluation import SkillOptions
from stages.config.packages import Package

PACKAGE = Package(commands={"skill": SkillOptions}, section="evaluation")
