"""Command `completion`: a script for the shell, after which the Tab key completes `roomkin`."""

from roomkin.stages.cli import find_module, list_flags
from roomkin.workflow import COMMANDS, ELSEWHERE, list_commands, list_homes

SCRIPT = """\
# ~/.bashrc: eval "$(roomkin completion)"
# ~/.zshrc, the same after: autoload -U compinit bashcompinit; compinit; bashcompinit
_roomkin() {{
    local words="" before=" ${{COMP_WORDS[*]:1:$((COMP_CWORD - 1))}} "
    case "$before" in
{cases}
    esac
    COMPREPLY=($(compgen -W "$words" -- "${{COMP_WORDS[COMP_CWORD]}}"))
}}
complete -o default -F _roomkin roomkin
"""


def run() -> None:
    """Print the script. Names of commands and flags are completed; where none fits, files."""
    homes = list_homes()
    cases = {'"  "': [*COMMANDS, *homes]}  # what stands before the word: what it may be
    for home, package in homes.items():
        cases[f'" {home} "'] = list_commands(package)
        cases |= {f'" {home} {one} "*': [*list_flags(f"{package}.{find_module(one)}")] for one in cases[f'" {home} "']}
    for command in COMMANDS:
        module, *words = ELSEWHERE.get(command, ["roomkin", command])
        cases[f'" {command} "*'] = [*list_flags(".".join([module, *map(find_module, words)]))]
    lines = (f'        {before}) words="{" ".join(after)}" ;;' for before, after in cases.items())
    print(SCRIPT.format(cases="\n".join(lines)), end="")
