"""The man pages of the program, from its own --help: camber(1), and camber-VERB(1) of each verb.

    man_pages.py build/bin/camber SHARE      writes SHARE/man/man1/camber.1, SHARE/man/man1/camber-curve.1 ...
"""
import pathlib
import re
import sys

import help_text


def escaped(text):
    """Text as roff in ASCII: no line of it is a request, and a minus is one that can be copied."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("^", "\\(ha").replace("~", "\\(ti").replace("`", "\\(ga")
    text = re.sub(r"(?m)^(?=[.'])", r"\\&", text)
    return "".join(c if c.isascii() else f"\\[u{ord(c):04X}]" for c in text)


def paragraphs(text):
    """Paragraphs, filled; lines that begin with a space, such as examples, as they stand."""
    out, verbatim = [], False
    for line in text.split("\n"):
        as_it_is = line.startswith(" ")
        if as_it_is != verbatim:
            out.append(".PP\n.nf" if as_it_is else ".fi\n.PP")
            verbatim = as_it_is
        if line:
            out.append(escaped(line))
        elif out and not verbatim:
            out.append(".PP")
    if verbatim:
        out.append(".fi")
    return re.sub(r"(\.PP\n)+", ".PP\n", "\n".join(out))


def entries(items):
    return "\n".join(f".TP\n.B {escaped(item.name)}\n{escaped(item.text)}" for item in items)


def first_sentence(text):
    """Of a description, for the line of NAME: its first, up to a full stop, a colon or a question mark."""
    flat = " ".join(text.split("\n\n")[0].split())
    return re.split(r"(?<=\?)\s|[.:](?:\s|$)", flat)[0]


def page(name, version, summary, shown, see):
    parts = [f'.TH {escaped(name).upper()} 1 "" "Camber {version}" "User Commands"',
             f".SH NAME\n{escaped(name)} \\- {escaped(summary)}",
             f".SH SYNOPSIS\n.B {escaped(shown.usage)}",
             f".SH DESCRIPTION\n{paragraphs(shown.description)}"]
    parts += [f".SH {title.upper()}\n{entries(items)}" for title, items in shown.lists.items()]
    if shown.footer:
        parts.append(f".SH NOTES\n{paragraphs(shown.footer)}")
    parts.append(".SH SEE ALSO\n" + ",\n".join(f".BR {escaped(other)} (1)" for other in see).replace("(1),", "(1),"))
    return "\n".join(parts) + "\n"


def pages(program):
    """The text of each page by its name."""
    version = help_text.said(program, "--version").strip()
    whole, verbs = help_text.of_program(program)
    texts = {"camber": page("camber", version, first_sentence(whole.description.partition(": ")[2]), whole,
                            [f"camber-{verb}" for verb in verbs])}
    for verb, shown in verbs.items():
        texts[f"camber-{verb}"] = page(f"camber-{verb}", version, first_sentence(shown.description), shown, ["camber"])
    return texts


def main(program, share):
    folder = pathlib.Path(share, "man", "man1")
    folder.mkdir(parents=True, exist_ok=True)
    for name, text in pages(program).items():
        (folder / f"{name}.1").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main(*sys.argv[1:])
