"""Completion for bash, from the program's own --help: verbs, their options, and the words that an option or a verb takes.

    completion.py build/bin/camber SHARE     writes SHARE/bash-completion/completions/camber
"""
import pathlib
import re
import sys

import help_text

SCRIPT = """\
# bash completion for camber {version}; made of its --help.
_camber() {{
    local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} verb=${{COMP_WORDS[1]}} words=
    COMPREPLY=()
    if ((COMP_CWORD == 1)); then
        words='{top}'
    else
        case $verb:$before in
{values}
        esac
        if [[ -z $words ]]; then
            case $verb:$word in
{options}
{positionals}
            esac
        fi
    fi
    [[ -z $words ]] || mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -o default -o bashdefault -F _camber camber
"""


def words_of(entry):
    """The words that an option takes: of `file|m|cm`, or those that its sentence lists where it is called NAME."""
    argument = entry.argument.split("=")[0]
    if re.fullmatch(r"[a-z0-9-]+(\|[a-z0-9-]+)+", argument):
        return argument.split("|")
    listed = re.search(r"\(([a-z0-9, -]+)\)", entry.text)
    return listed.group(1).split(", ") if argument == "NAME" and listed else []


def explained_words(program):
    """The words that `camber explain` lists, but for those with blanks."""
    lines = help_text.said(program, "explain").split("\n")
    words = ", ".join(line.strip().rstrip(",") for line in lines if line.startswith("  ")).split(", ")
    return list(dict.fromkeys(word for word in words if re.fullmatch(r"[A-Za-z0-9_-]+", word)))


def case(patterns, words):
    return f"        {'|'.join(patterns)}) words='{' '.join(words)}' ;;"


def script(program):
    whole, verbs = help_text.of_program(program)
    version = help_text.said(program, "--version").strip()
    top = [*verbs, *(spelling for entry in whole.options for spelling in entry.options if spelling.startswith("--"))]
    values, options = [], []
    for verb, shown in verbs.items():
        for entry in shown.options:
            if words_of(entry):
                values.append(case([f"{verb}:{spelling}" for spelling in entry.options], words_of(entry)))
        spellings = [spelling for entry in shown.options for spelling in entry.options if spelling.startswith("--")]
        options.append("    " + case([f"{verb}:-*"], spellings))
    positionals = ["    " + case(["explain:*"], explained_words(program)), "    " + case(["help:*"], list(verbs))]
    return SCRIPT.format(version=version, top=" ".join(top), values="\n".join(values), options="\n".join(options),
                         positionals="\n".join(positionals))


def main(program, share):
    folder = pathlib.Path(share, "bash-completion", "completions")
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "camber").write_text(script(program), encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
