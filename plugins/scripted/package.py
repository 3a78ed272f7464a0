"""The package as the core knows it."""

from roomkin.stages.config.evaluation import SkillOptions
from roomkin.stages.config.packages import Package

PACKAGE = Package(commands={"skill": SkillOptions}, section="evaluation")
