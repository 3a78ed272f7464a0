"""What the core must know of this package."""

from stages.config.evaluation import SkillOptions
from stages.config.packages import Package

PACKAGE = Package(commands={"skill": SkillOptions}, section="evaluation")
