"""The program's own --help as values: what man pages and completion are made of."""
import dataclasses
import re
import subprocess

COLUMN = 30  # where the texts of entries begin
OPTIONS = ("Options", "Input", "Geometry", "Metric", "Quality", "Output", "Run")  # titles of lists of options
SECTION = re.compile(rf"^(Positionals|Subcommands|{'|'.join(OPTIONS)}):$")


@dataclasses.dataclass
class Entry:
    """A line of a list: its name as it stands (`-o,--output TEXT REQUIRED`) and its sentence."""

    name: str
    text: str

    @property
    def options(self):
        """The spellings of an option; none for a positional or a verb."""
        return re.findall(r"(?<![^\s,])--?[A-Za-z][A-Za-z0-9-]*", self.name.split(" ")[0])

    @property
    def argument(self):
        """What is written behind the option, such as TEXT or file|m|cm; empty where nothing is."""
        return self.name.partition(" ")[2]


@dataclasses.dataclass
class Help:
    """Of the program or of one verb: paragraphs before the usage, the usage, lists by title, paragraphs at the end."""

    description: str = ""
    usage: str = ""
    lists: dict = dataclasses.field(default_factory=dict)
    footer: str = ""

    @property
    def options(self):
        return [entry for title in OPTIONS for entry in self.lists.get(title, [])]


def split_entry(line):
    """A list's line in its name and the begin of its text: a name that is too wide has its text on the next lines."""
    front = line[:COLUMN]
    brackets = sum(front.count(c) for c in "([") - sum(front.count(c) for c in ")]")
    if len(line) > COLUMN and front.endswith(" ") and brackets == 0:
        return front.strip(), line[COLUMN:].strip()
    return line.strip(), ""


def parsed(text):
    """The Help that `text` says."""
    out, title, before = Help(), None, []
    lines = text.split("\n")
    for line in lines:
        section = SECTION.match(line)
        if section:
            title = section.group(1)
            out.lists[title] = []
        elif line.startswith("Usage: ") and not out.usage:
            out.usage = line.removeprefix("Usage: ")
            out.description = "\n".join(before).strip("\n")
        elif not out.usage:
            before.append(line)
        elif title and line.startswith(" " * COLUMN):
            entry = out.lists[title][-1]
            entry.text = f"{entry.text} {line.strip()}".strip()
        elif title and line.startswith("  "):
            out.lists[title].append(Entry(*split_entry(line)))
        elif line or out.footer:
            title, out.footer = None, out.footer + line + "\n"
    out.footer = out.footer.strip("\n")
    return out


def said(program, *arguments):
    """What the program prints, in lines of its full width: it is no terminal that reads."""
    return subprocess.run([program, *arguments], capture_output=True, text=True, check=True).stdout


def of_program(program):
    """The Help of the program, and that of each of its verbs by name."""
    whole = parsed(said(program, "--help"))
    verbs = {entry.name: parsed(said(program, entry.name, "--help-all")) for entry in whole.lists["Subcommands"]}
    return whole, verbs
