"""What the pages of the repository name: paths, links, verbs and their options, code. documents.py runs their commands;
here that check itself is checked, on some."""

import ast
import glob
import json
import os
import re
import shlex
import subprocess

from case import BUILD, PROGRAM, SOURCE, Case, main
from documented import NOT_PRINTED, PAGES, Page, Printed, Ran, findings, not_printed, read

FOLDERS = "|".join(sorted(f for f in os.listdir(SOURCE)
                          if os.path.isdir(os.path.join(SOURCE, f)) and not re.match(r"\.|build", f)))
KINDS = "md|hpp|cpp|json|py|sh|mjs|cmake|txt"
# Made by a run, or a reader's own: "my.json" and the like stand for a file; these are named as such on their pages.
NOT_OF_THE_REPOSITORY = {"info.json", "job.json", "array.sh", "merge.sh", "submit.sh", "NAME.partial.json",
                         "off_the_face_with_a_cleaved_end_and_a_gas.json"}


def prose(page):
    return re.sub(r"^```\w*\n.*?^```$", "", read(page), flags=re.S | re.M)


def named(page):
    """Code in the prose that is neither a command nor an option."""
    return [code for code in re.findall(r"`([^`\n]+)`", prose(page)) if not re.search(r"[\s<>]|^-|NAME", code)]


def options_of(verb):
    return set(re.findall(r"(?<![\w-])--?[a-z][A-Za-z-]*", read(f"app/help/{verb}.txt"))) | {"--help"}


VERBS = {os.path.basename(f)[:-4] for f in glob.glob(os.path.join(SOURCE, "app/help/*.txt"))} - {"ferrule"}
STAND_FOR_ONE = {"VERB", "..."}
OF_THE_START_SCRIPT = {"test": {"--long", "--compile"}, "wheel": set(), "playground": set(), "package": set()}


class Names(Case):
    def exists(self, page, path):
        return any(glob.glob(os.path.join(SOURCE, folder, path + end))
                   for folder in ("", os.path.dirname(page)) for end in ("", ".hpp"))

    def test_paths_exist(self):
        count = 0
        for page in PAGES:
            with self.subTest(page=page):
                for path in named(page):
                    if re.match(f"({FOLDERS})/", path):
                        self.assertTrue(self.exists(page, path), path)
                        count += 1
        self.assertGreater(count, 150)

    def test_files_exist(self):
        files = {os.path.basename(f) for folder in FOLDERS.split("|")
                 for f in glob.glob(os.path.join(SOURCE, folder, "**/*.*"), recursive=True)}
        for page in PAGES:
            with self.subTest(page=page):
                made = {word for command in Page(read(page)).commands for word in command.text.split()}
                for name in named(page):
                    if re.fullmatch(rf"[\w.-]*\w\.({KINDS})", name) and name not in made | NOT_OF_THE_REPOSITORY:
                        self.assertTrue(name in files or self.exists(page, name), name)

    def test_scenes_exist(self):
        for page in PAGES:
            with self.subTest(page=page):
                for scene in re.findall(r"`((?:ladder|by_hand)/\w+)`|--scene ((?:ladder|by_hand)/\w+)", read(page)):
                    scene = "".join(scene)
                    self.assertTrue(os.path.exists(os.path.join(SOURCE, f"data/scenes/{scene}.json")), scene)

    def test_links_lead_somewhere(self):
        def anchors(page):
            headings = re.findall(r"^#+ (.*)$", prose(page), re.M)
            return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-") for heading in headings}

        count = 0
        for page in PAGES:
            with self.subTest(page=page):
                for path, anchor in re.findall(r"\]\(([^)#\s:]*)(?:#([^)\s]*))?\)", prose(page)):
                    target = os.path.normpath(os.path.join(os.path.dirname(page), path)) if path else page
                    self.assertTrue(os.path.exists(os.path.join(SOURCE, target)), path)
                    if anchor:
                        self.assertIn(anchor, anchors(target))
                    count += 1
        self.assertGreater(count, 50)

    def test_what_no_command_prints_stands_beside_one(self):
        for page, phrases in NOT_PRINTED.items():
            Page(read(page), phrases)  # raises

    def test_verbs_and_options_exist(self):
        count = 0
        for page in PAGES:
            with self.subTest(page=page):
                for command in [command.text for command in Page(read(page)).commands if command.language == "sh"]:
                    words = shlex.split(command.replace("...", " "), comments=True)[1:]
                    for at, word in enumerate(words):
                        if word in (">", "|", "&&", ";"):
                            words = words[:at]
                            break
                    while words and words[0] not in VERBS | set(OF_THE_START_SCRIPT):
                        self.assertIn(words[0], STAND_FOR_ONE | {"--help", "--version", "[OPTION"}, command)
                        words = words[1:]
                    if not words:
                        continue
                    if "--" in words:  # the job of submit
                        at = words.index("--")
                        jobs = [words[:at], words[at + 1:]]
                    else:
                        jobs = [words]
                    for verb, *arguments in jobs:
                        known = OF_THE_START_SCRIPT[verb] if verb in OF_THE_START_SCRIPT else options_of(verb)
                        for word in arguments:
                            if word.startswith("--"):
                                self.assertIn(word.split("=")[0], known | {"--shard"}, command)
                                count += 1
        self.assertGreater(count, 500)

    def test_every_force_has_a_colour(self):
        laws = read("sim/laws/laws.hpp").split("kTermNames = {")[1].split("}")[0]
        forces = re.findall(r'"(\w+)"', laws)
        self.assertGreater(len(forces), 10)
        theme = read("view/page/src/theme.js").split("kTerms = [")[1].split("]")[0]
        self.assertEqual(re.findall(r"'(\w+)'", theme), forces)
        style = read("view/page/src/style.css")
        for force in forces:
            self.assertEqual(style.count(f"--{force.replace('_', '-')}: #"), 3, force)  # dark: chosen, or the system's

    def test_options_in_the_text_exist(self):
        known = set(re.findall(r'"(--[a-z-]+)"', read("bench/results.py")))
        known = known.union(*map(options_of, VERBS), *OF_THE_START_SCRIPT.values())
        for page in PAGES:
            with self.subTest(page=page):
                for option in re.findall(r"`(--[a-z][A-Za-z-]*)", prose(page)):
                    self.assertIn(option, known | {"--version"})


class BuildTimes(Case):
    def test_the_table_is_of_nearly_these_sources(self):
        git = ["git", "-C", SOURCE]
        commit, = re.findall(r"at commit (\w+) on", read("docs/building.md"))
        if subprocess.run([*git, "cat-file", "-e", commit + "^{commit}"], capture_output=True).returncode:
            self.skipTest(f"the history of this clone does not reach back to {commit}")
        sources, changed = (subprocess.run([*git, *words, "--", "*.cpp", "*.hpp", ":!tests"], capture_output=True, text=True,
                                           check=True).stdout.splitlines()
                            for words in (["ls-files"], ["diff", "--name-only", commit]))
        self.assertGreater(len(sources), 300)
        self.assertLessEqual(len(changed), len(sources) / 10, "make the table again: bench/build_times.py")

    def test_the_script_makes_it_of_any_build(self):
        page = self.path("building.md")
        with open(page, "w") as file:
            file.write("<!-- build_times -->\n<!-- /build_times -->\n")
        script = [os.path.join(SOURCE, "bench/build_times.py"), "--into", page, "--build"]
        wrong = subprocess.run([*script, self.folder], capture_output=True, text=True)
        self.assertEqual((wrong.returncode, wrong.stderr.count("\n")), (2, 1), wrong.stderr)
        subprocess.run([*script, BUILD], check=True)
        with open(page) as file:
            rows = [line.split("|")[1:-1] for line in file if re.match(r"\|.*\d \|$", line)]
        self.assertEqual(len(rows), 6)
        for _, objects, each, together in rows:
            self.assertGreater(int(objects), 0)
            self.assertLessEqual(float(together), float(each))


# The program in the hands of a mutant. A documented command that it runs must be found not to be as its page says.
MUTANTS = {
    "does nothing": "exit 0",
    "is silent": '"$program" "$@" >/dev/null 2>&1',
    "fails": '"$program" "$@"; exit 1',
    "has numbers off by a tenth": r"""
      "$program" "$@" | perl -pe 's/(?<![\w.])(\d+\.?\d*)/$1*1.1/ge unless /^made by/'""",
    "loses an option": r"""
      for ((k = 1; k < $#; ++k)); do
        if [[ ${!k} == --* ]]; then set -- "${@:1:k-1}" "${@:k+2}"; break; fi
      done
      "$program" "$@" """,
    "does not hear its options": r"""
      "$program" "$1" | sed "s|^\(made by [^)]*): \).*|\1ferrule $*|" """,
    "leaves empty files": r"""
      "$program" "$@"
      if [[ $* == *--plot* ]]; then : >"${@: -1}"; fi""",
}
# A page, and a command of the block of it that they run: quick ones.
NUMBERS = (("controller/README.md", "limits --scene bench"), ("docs/paper.md", "forces --scene paper --gap-nm 10 "))
FILES = (("docs/paper.md", "--plot fig7-printed.svg"),)


def part(name, command):
    page = Page(read(name), NOT_PRINTED.get(name, []))
    block = next(each.block for each in page.commands if command in each.text)
    page.commands = [each for each in page.commands if each.block == block]
    return page


class Check(Case):
    """That what is wrong with a documented command is found."""

    def found(self, script, page):
        with open(self.path("ferrule"), "w") as program:
            program.write(f"#!/bin/bash\nprogram={PROGRAM}\n{script}\n")
        os.chmod(self.path("ferrule"), 0o755)
        for file in glob.glob(self.path("*.svg")):
            os.remove(file)
        return findings(page, self.run_in_folder, self.folder)

    def run_in_folder(self, _, command):
        run = subprocess.run(["bash", "-c", command], cwd=self.folder, capture_output=True, text=True, timeout=60)
        return Ran(run.returncode, run.stdout, run.stderr)

    def test_the_program_is_as_its_pages_say(self):
        for name, command in NUMBERS + FILES:
            self.assertEqual(self.found('exec "$program" "$@"', part(name, command)), [])

    def test_mutants_are_found(self):
        parts = {"has numbers off by a tenth": NUMBERS, "leaves empty files": FILES}
        for mutant, script in MUTANTS.items():
            for name, command in parts.get(mutant, NUMBERS + FILES):
                page = part(name, command)
                with self.subTest(mutant=mutant, page=name, command=command):
                    wrong = {what for what, _ in self.found(script, page)}
                    self.assertTrue(wrong)
                    if mutant not in ("has numbers off by a tenth", "does not hear its options"):
                        self.assertEqual({each.text for each in page.commands} - wrong, set())

    def test_pages_with_a_wrong_number_are_found(self):
        found = []
        for name, command in NUMBERS:
            page = part(name, command)
            block = page.commands[0].block
            printed = Printed()
            for each in page.commands:
                printed.add(self.run_in_folder("sh", each.text.replace("./ferrule", PROGRAM)))
            for number in re.findall(r"\d+\.\d+", page.beside[block]):
                off = re.sub(rf"(?<![\d.]){re.escape(number)}(?!\d)", f"{float(number) * 1.1:.4g}", page.beside[block])
                found.append(bool(not_printed(off, printed)))
        self.assertGreater(len(found), 10)
        self.assertGreater(sum(found), 0.8 * len(found))


class Code(Case):
    def code(self, language):
        return [(page, block) for page in PAGES
                for block in re.findall(rf"^```{language}\n(.*?)^```$", read(page), re.S | re.M)]

    def test_python_is_python(self):
        self.assertGreater(len(self.code("python")), 8)
        for page, block in self.code("python"):
            with self.subTest(page=page):
                ast.parse(block)

    def test_cpp_compiles(self):
        with open(os.path.join(BUILD, "compile_commands.json")) as file:
            words = next(shlex.split(entry["command"]) for entry in json.load(file) if "/examples/" in entry["file"])
        flags = [word for before, word in zip([""] + words, words)
                 if re.match(r"-(I|std|f|W)", word) and before != "-Xclang"] + \
                [word for pair in zip(words, words[1:]) if pair[0] == "-isystem" for word in pair]
        compiler = next(word for word in words if re.search(r"(\+\+|cc)(-\d+)?$", word))
        self.assertTrue(self.code("cpp"))
        for page, block in self.code("cpp"):
            with self.subTest(page=page):
                file = self.path("block.cpp")
                with open(file, "w") as out:
                    includes = re.findall("^#include.*$", block, re.M)
                    out.write("\n".join(includes + ["int main() {", re.sub("(?m)^#include.*$", "", block), "}"]))
                run = subprocess.run([compiler, *flags, "-fsyntax-only", file], capture_output=True, text=True)
                self.assertEqual(run.returncode, 0, run.stderr)


if __name__ == "__main__":
    main()
