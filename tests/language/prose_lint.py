#!/usr/bin/env python3
"""Checks the language of the tree: comments, messages, names of tests and identifiers, and Markdown pages.

The tool reads tracked C++, CUDA, Python and Markdown files. In code it reads comments, and strings of three words or more;
with --identifiers also the names. It prints counts by rule and folder. It exits with 1 if a limit is exceeded, and with 2 if
it cannot run. EXCEPTIONS lists hits that are right where they stand, with the reason. LIMITS holds the allowed count of
each rule; ctest runs the tool with it, so that no count rises.

    prose_lint.py [ROOT] [--list RULE[,RULE]] [--limit N | --limit RULE=N ...] [--limits] [--under PATH] [--identifiers]
                  [--commits RANGE] [--words]
"""

import argparse
import collections
import functools
import io
import json
import re
import subprocess
import sys
import tokenize
from pathlib import Path

MAX_WORDS = {"comment": 30, "string": 30, "markdown": 35}
MAX_COLUMNS = 100
MAX_README_LINES = 40
MAX_TEST_NAME = 72
MAX_SUBJECT = 72
# Files of measurements and pages that docs/render_measurements.py writes: the only ones for commit hashes.
MEASUREMENTS = ("docs/measurements/", "docs/performance", "docs/validation.md", "docs/long-validation.md", "docs/figures.md", "docs/coverage.md",
                "docs/experiments.md")
HISTORY_ALLOWED = MEASUREMENTS + ("CHANGELOG.md",)
HERE = Path(__file__).resolve().parent
EXCEPTIONS, LIMITS = HERE / "prose_exceptions.txt", HERE / "prose_limits.json"
OWN_TEXT = ("docs/developers/glossary.md", "tests/language/prose_lint.py", "tests/language/prose_lint_test.py")  # quote private words

# Private words in prose (regex, plain term). Word boundaries are added.
PRIVATE = [
    (r"felt|feels?", "field at a particle; 'is subject to'"),
    (r"who|whom|whoever", "name the subject: body, thread, caller, user"),
    (r"nobody|somebody|everybody", "name the component"),
    (r"asks?|asked", "requests / requested / calls"),
    (r"tells?|told", "reports / returns / specified"),
    (r"knows?|knew", "stores / depends on / is given"),
    (r"anew", "again; from scratch"),
    (r"dear|dearer", "expensive"),
    (r"jolts?|jolted", "velocity kick"),
    (r"glances?", "check"),
    (r"company", "neighbours in contact"),
    (r"patience|patient", "deferral time; spin count"),
    (r"squeez\w+", "narrow; merge duplicates"),
    (r"rooms?", "directory; memory; capacity; clearance"),
    (r"sentences?", "error message"),
    (r"(?<!random )walk(?:s|ed)?", "algorithm; traversal"),
    (r"ma[dk](?:e|es|ing) up for|make-ups?", "correct; defect correction"),
    (r"book(?:s|ed|ing)?", "record; energy budget"),
    (r"held", "fixed (bodies); constant (forces); stored (charge)"),
    (r"stands?", "is stored; is defined; is committed"),
    (r"ways?(?<!this way)(?<!same way)(?<!either way)", "displacement; distance; path; method"),
    (r"places|(?:its|their|whose|a|each) place", "positions; indices"),
    (r"turn(?:s|ed|ing)?(?! into| on| off)", "rotation; winding number"),
    (r"bound cells?", "eliminated near-surface cell"),
    (r"thin conductors?", "subgrid conductor (Peaceman)"),
    (r"mergers?", "group merge; contact closing; coalescence"),
    (r"partings?", "group split; contact opening"),
    (r"fores(?:ee|ees|een|aw)|foretold", "predict; estimate"),
    (r"promis\w+", "error bound; guarantee"),
    (r"beside", "next to; in addition to"),
    (r"alike", "identical; equal"),
    (r"like one", "as one agglomerate"),
    (r"all but", "nearly, or all except: say which"),
    (r"nothing but", "only"),
    (r"but for", "except for"),
    (r"so (?:much|many|few)", "give the symbol: n, dt, ..."),
    (r"as (?:they|it) likes?", "arbitrary"),
    (r"looked (?:at|for)|looks? (?:at|for)", "search; test; inspect"),
    (r"push(?:es|ed)?", "contact force; contact acceleration"),
    (r"(?:pulls?|pulled)(?! request)", "attraction; external acceleration"),
    (r"bears?|bend|bends", "carry a load; deviation"),
    (r"crowd(?:s|ed|ing)?", "dense system; multi-body contact"),
    (r"lone", "isolated"),
    (r"fed", "injected"),
    (r"gives? way|given way", "loses contact; yields"),
    (r"comes? along", "arrives; occurs"),
    (r"one after the other", "sequentially; contiguously"),
    (r"in between", "between A and B: name both"),
    (r"(?:twentie|fiftie|thirtie|sixteen|hundred|thousand)ths?", "5 %, 2 %, 1/30, ..."),
    (r"by hand", "given explicitly; set manually"),
]

# Openers of a comment, docstring or bullet that leave out the noun they speak of.
HEADLESS = re.compile(
    r"(?:Of (?!course\b)\w+|What\b|Who\b|Whom\b|That which\b|Those\b|The same\b|The others?\b|That\b(?! is[,:])|Where\b"
    r"|How\b(?! to\b)|Which\b|By (?:which|what|how)\b|So (?:much|many)\b|As (?:many|much|far|long) \w+|One (?:that|of|thing)\b"
    r"|Things?\b|All (?:that|there|of)\b|Nothing\b|Nobody\b|Begun\b|Such\b|It\b|They\b|Its\b|Their\b)")

HISTORY = r"used to be|since then|by now|before and now|once more|as they are now|of today|until now|nowadays|" \
          r"than before|was before|were before|in place of what"

# Private identifiers: exact names (regex) and the proposed name.
IDENTIFIERS = [
    (r"Felt|CompensatedFelt|FeltSums?|felt_?", "FieldSample, field_at_source"), (r"near_felt", "near_field_at_source"),
    (r"Most", "MaxReduction"), (r"Largest", "StepMaxima"), (r"GasOn", "GasImpl"),
    (r"jolts?_?", "velocity_kick"), (r"pull_?", "external_acceleration"),
    (r"bear", "update_contact_acceleration"), (r"bend", "contact_deviation"),
    (r"[cC]over", "is_valid_for (Encounters), CellOwner (cutcell)"), (r"glance", "select_candidates, peek"),
    (r"mark_company", "mark_shared_contacts"),
    (r"learn_patience|patience_?|merger_patience", "merge_deferral"), (r"Lateness|lateness|late_by", "MergeDelay"),
    (r"Lookahead", "ContactPrediction"), (r"Lookout|lookout", "EventOvershoot"),
    (r"foresee|Foreseen|foreseen|foreseen_\w+", "predict, Prediction"), (r"go_back", "rollback"),
    (r"make_up|make_up_\w+|made_up", "correct_defect"),
    (r"EnergyBook|FieldBook|book|book_\w+", "EnergyBudget, record_*"),
    (r"Drive", "ExternalForcing"), (r"TurnsAround", "ImageCount"), (r"Turns", "FixedPointPosition"),
    (r"turns_a_metre", "inverse_length"), (r"over_mass", "inverse_mass"), (r"Quanta", "FixedPointScale"),
    (r"AskedBodies|AskedField|asked|asked_?", "RequestedBodies, requested"), (r"Spot|spots_?", "SortedParticle"),
    (r"spot|make_spot|refuse_spot", "contact_radius"), (r"Encounters|encounters_?", "ContactEventQueue"),
    (r"TouchedGrains", "ContactingGrains"), (r"Touch", "ContactOnset"), (r"PairSeen", "PairGeometry"),
    (r"Parcel", "PackedTransfer"), (r"make_room|check_room|put_room|Room|room", "reserve, check_memory, capacity"),
    (r"squeeze_links|Squeeze", "couple_opposed_surfaces"),
    (r"BoundCells|bind_cell|build_bound|is_bound|start_bound|bound_cells?\w*", "EliminatedCells"),
    (r"\w*thin_conductors?|is_thin|thin_conductance", "subgrid_conductors"), (r"narrow_row", "subtract_closed_faces"),
    (r"level_out", "fix_potential_level"), (r"[sS]meared", "homogenized"), (r"Sets|SetLists", "Agglomerates"),
    (r"Met|Meeting", "TailInteraction"), (r"Given", "ChargeConstraint"), (r"Wanted", "SolveTarget"),
    (r"Past|PastView", "SolutionHistory"), (r"Several", "SimdPack"),
    (r"Seen|Found|Sought|Brought|Begun|Kept|Kicked|Picked|Located|Followed", "name the object"),
    (r"Those|Others|Elsewhere|Otherwise|Beyond|Between|Among|Again|CudaAgain|GoOn|NoMore|Later|Then",
     "name the operation"),
    (r"of_(?!run|type)\w+|OfBody|OfGrid|OfPairs|OfParts|OfRow|OfGrain", "noun + index"),
    (r"Backlog", "TaskQueue"), (r"Holders", "SourceAssignment"), (r"Supply", "PotentialSource"),
    (r"Experience", "CostCalibration"), (r"Circumstances", "BenchmarkEnvironment"), (r"Price|price_\w+", "CostModel"),
    (r"Survey|survey_\w+", "GrainStatistics"), (r"Studio", "FigureContext"), (r"Sheet", "Canvas"), (r"Eye", "Camera"),
    (r"Remark|Remarks", "Warning"), (r"Course|\w+Course", "TimeSeries"),
    (r"ContactPush|push_of|hardest_push_?|mark_pushed", "ContactForceTerms, max_contact_acceleration"),
    (r"apart|apart_for_?|apart_with", "separation, min_time_to_contact"), (r"places?_?|place_of", "position(s)"),
    (r"way|ways|way_for|way_of", "displacement"), (r"blind_way", "undetected_travel"),
    (r"let_go\w*", "release_contact"), (r"leave_behind", "start_background_task"),
    (r"settle\w*", "finalize, update_lists"), (r"share_out", "redistribute"),
    (r"becomes?_\w+|tell_\w+|sentence_about|last_sentence", "state the action"),
    (r"check_hope|refuse_hopeless", "check_solvable"), (r"Parts|Part|Piece|Pieces", "name the component"),
    (r"keep_height", "fix_z"), (r"everybody|nobody", "all_active"),
]

KINDS = ("comment", "string", "markdown")
RULES = ("private", "what", "headless", "sentence", "test-name", "history", "hash", "md-width", "readme-lines")

private_re = [(re.compile(r"\b(?:%s)\b" % rx, re.I), rx, plain) for rx, plain in PRIVATE]
history_re = re.compile(r"\b(?:%s)\b" % HISTORY, re.I)
any_private_re = re.compile("|".join(rx.pattern for rx, _, _ in private_re), re.I)
identifier_re = [(re.compile(rx), rx, plain) for rx, plain in IDENTIFIERS]
what_re = re.compile(r"\bwhat\b", re.I)
hash_re = re.compile(r"\b(?=[0-9a-f]*[a-f])(?=[0-9a-f]*[0-9])[0-9a-f]{7,40}\b")
token_re = re.compile(
    r'//[^\n]*|/\*.*?\*/|R"(\w*)\(.*?\)\1"|"(?:\\.|[^"\\\n])*"|(?<![0-9A-Za-z_])\'(?:\\.|[^\'\\\n])*\'', re.S)
marker_re = re.compile(r"^\s*(?:///<|///|//!|//|/\*\*?|#+)\s?|\s*\*/\s*$")
ignored_re = re.compile(r"^\s*(?:namespace\b|clang-format|NOLINT|noqa|type:|pylint|!/)")
name_re = re.compile(r"\w+")
word_re = re.compile(r"[A-Za-z][A-Za-z'’-]*")
sentence_end = re.compile(r"(?<=[.!?])[\"')\]]*\s+(?=[A-Z`\"(\[*0-9])")


class Text:
    """One block of prose: where it begins, its kind, and its lines."""

    def __init__(self, path, line, kind, text):
        self.path, self.line, self.kind, self.text = path, line, kind, text


def cpp_texts(path, source):
    texts, code, last = [], [], 0
    block = None  # (first line, last line, lines) of // comments on lines of their own
    for m in token_re.finditer(source):
        code.append(source[last:m.start()])
        code.append("\n" * m.group(0).count("\n") or " ")
        last = m.end()
        line = source.count("\n", 0, m.start()) + 1
        token = m.group(0)
        if token[0] == "/":
            text = " ".join(marker_re.sub("", part).strip(" *") for part in token.split("\n")).strip()
            if ignored_re.match(text) or not text:
                continue
            start = source.rfind("\n", 0, m.start()) + 1
            own_line = not source[start:m.start()].strip()
            if block and own_line and line == block[1] + 1:
                block[1] = line
                block[2].append(text)
            else:
                if block:
                    texts.append(Text(path, block[0], "comment", " ".join(block[2])))
                block = [line, line if own_line else -1, [text]]
        elif token[0] == '"' or token[0] == "R":
            body = re.sub(r'^R"\w*\(|\)\w*"$', "", token).strip('"')
            before = source[max(0, m.start() - 60):m.start()]
            kind = "test" if re.search(r"TEST_CASE\w*\(\s*$", before) else "string"
            texts.append(Text(path, line, kind, body))
    if block:
        texts.append(Text(path, block[0], "comment", " ".join(block[2])))
    code.append(source[last:])
    return texts, "".join(code)


def python_texts(path, source):
    texts, code, block = [], [], None
    for t in tokenize.generate_tokens(io.StringIO(source).readline):
        name = tokenize.tok_name[t.type]
        if t.type == tokenize.COMMENT:
            text = marker_re.sub("", t.string)
            if ignored_re.match(text):
                continue
            if block and not t.line[:t.start[1]].strip() and t.start[0] == block[1] + 1:
                block[1] = t.start[0]
                block[2].append(text)
            else:
                if block:
                    texts.append(Text(path, block[0], "comment", " ".join(block[2])))
                block = [t.start[0], t.start[0], [text]]
        elif t.type == tokenize.STRING or name == "FSTRING_MIDDLE":
            doc = t.string.lstrip("rRbBuUfF").startswith('"""')
            body = re.sub(r"^[rRbBuUfF]*(\"\"\"|'''|\"|')|(\"\"\"|'''|\"|')$", "", t.string)
            texts.append(Text(path, t.start[0], "comment" if doc else "string", re.sub(r"\s+", " ", body)))
        elif t.type == tokenize.NAME:
            code.append((t.start[0], t.string))
    if block:
        texts.append(Text(path, block[0], "comment", " ".join(block[2])))
    lines, at = [], 1
    for line, name in code:
        lines.append("\n" * (line - at) + " " + name)
        at = line
    return texts, "".join(lines)


def markdown_texts(path, source):
    texts, block, fenced = [], None, False

    def close():
        nonlocal block
        if block:
            texts.append(Text(path, block[0], "markdown", " ".join(block[1])))
        block = None

    for number, line in enumerate(source.split("\n"), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            close()
            continue
        if fenced:
            continue
        starts = re.match(r"\s*(?:[-*+]|\d+\.)\s+|#+\s+|\s*\||\s*$", line)
        if starts:
            close()
        text = re.sub(r"^\s*(?:[-*+]|\d+\.)\s+|^#+\s+", "", line)
        text = re.sub(r"\|", " . ", text) if line.lstrip().startswith("|") else text
        if text.strip():
            block = block or (number, [])
            block[1].append(text)
        if line.startswith("#") or line.lstrip().startswith("|"):
            close()
    close()
    return texts


def plain(text):
    """Without inline code, links and paths: only words that a reader reads as prose."""
    text = re.sub(r"`[^`]*`", "X", text)
    text = re.sub(r"\]\([^)]*\)", "]", text)
    text = re.sub(r"\b([Uu]sers?|[Rr]eaders?|[Aa]uthors?|[Dd]evelopers?|[Pp]eople) who\b", r"\1 that", text)
    return re.sub(r"https?://\S+", "X", text)


@functools.cache
def private_names(word):
    """Returns (regex, proposed name) for each entry of IDENTIFIERS that an identifier matches."""
    return [(name, term) for rx, name, term in identifier_re if rx.fullmatch(word)]


def folder(path):
    parts = path.split("/")[:-1]
    return "/".join(parts[:3] if parts[:2] == ["solvers", "laplace"] else parts[:2]) or "."


def check(text, prose, report):
    """`prose` is the plain text."""
    words = word_re.findall(prose)
    if text.kind in ("string", "test") and len(words) < 3:
        return
    hit = lambda rule, what: report(rule, text.path, text.line, what, text.kind)
    if any_private_re.search(prose):  # most texts have none, and one search takes less time than one for each word
        for rx, _, term in private_re:
            for m in rx.finditer(prose):
                hit("private", f"{m.group(0)} -> {term}")
    for m in what_re.finditer(prose):
        if not prose.rstrip().endswith("?"):
            hit("what", prose[max(0, m.start() - 20):m.end() + 25].strip())
    if text.kind in ("comment", "markdown"):
        m = HEADLESS.match(prose.strip())
        if text.kind == "markdown" and m and m.group(0) in ("It", "They", "Its", "Their", "That", "Those", "Such"):
            m = None  # a paragraph may refer to the one above; a comment stands alone
        if m and not prose.rstrip().endswith("?"):
            hit("headless", prose.strip()[:60])
    for sentence in sentence_end.split(prose):
        n = len([w for w in word_re.findall(sentence) if len(w) > 1 or w in "aI"])
        if n > MAX_WORDS.get(text.kind, 30):
            hit("sentence", f"{n} words: {sentence.strip()[:60]}")
    if text.kind == "test" and len(text.text) > MAX_TEST_NAME:
        hit("test-name", f"{len(text.text)} characters: {text.text[:60]}")
    if not text.path.startswith(HISTORY_ALLOWED):
        for m in history_re.finditer(prose):
            hit("history", prose[max(0, m.start() - 20):m.end() + 25].strip())
    if text.kind != "string" and not text.path.startswith(HISTORY_ALLOWED):
        for m in hash_re.finditer(text.text):
            hit("hash", m.group(0))


def check_markdown_lines(path, source, report):
    lines, fenced = source.rstrip("\n").split("\n"), False
    for number, line in enumerate(lines, 1):
        fenced ^= line.lstrip().startswith("```")
        if len(line) > MAX_COLUMNS and not fenced and not line.lstrip().startswith("|") and " " in line.strip():
            report("md-width", path, number, f"{len(line)} columns", "markdown")
    if path.endswith("/README.md") and not path.startswith("docs/") and len(lines) > MAX_README_LINES:
        report("readme-lines", path, 1, f"{len(lines)} lines", "markdown")


def read_exceptions(text):
    """Returns (rule, start of the path, words of the hit) for each line `RULE PATH: WORDS  # REASON`."""
    exceptions = []
    for line in text.split("\n"):
        entry = line.split("  #")[0].strip()
        if entry and not entry.startswith("#"):
            where, words = entry.split(": ", 1)
            rule, path = where.split(" ", 1)
            exceptions.append((rule, path, words))
    return exceptions


def git(root, *arguments):
    return subprocess.run(["git", "-C", root, *arguments], check=True, capture_output=True, text=True).stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("root", nargs="?", default=".")
    parser.add_argument("--list", default="", help="print the hits of these rules")
    parser.add_argument("--limit", action="append", default=[], help="N for the total, or RULE=N")
    parser.add_argument("--limits", action="store_true", help="the limits of prose_limits.json; implies --identifiers")
    parser.add_argument("--under", default="", help="only files below this path")
    parser.add_argument("--identifiers", action="store_true", help="also look for private names in code")
    parser.add_argument("--commits", help="also check the subjects of these commits, such as main..HEAD")
    parser.add_argument("--words", action="store_true", help="print the counts of each private word")
    options = parser.parse_args()
    exceptions = read_exceptions(EXCEPTIONS.read_text(encoding="utf-8"))
    if options.limits:
        options.identifiers = True
        options.limit += [f"{rule}={most}" for rule, most in json.loads(LIMITS.read_text(encoding="utf-8")).items()]

    counts, by_word, by_name = collections.Counter(), collections.Counter(), collections.Counter()
    listed, lengths, total_words = set(options.list.split(",")), collections.Counter(), collections.Counter()

    def report(rule, path, line, what, kind):
        if any(rule == r and path.startswith(p) and words in what for r, p, words in exceptions):
            return
        counts[rule, folder(path)] += 1
        counts[rule, "kind:" + kind] += 1
        if rule == "private":
            by_word[what.split(" -> ")[1], what.split(" -> ")[0].lower()] += 1
        if rule in listed:
            print(f"{path}:{line}: {rule}: {what}")

    try:
        files = git(options.root, "ls-files", "*.cpp", "*.hpp", "*.cu", "*.cuh", "*.py", "*.md").split("\n")[:-1]
    except (OSError, subprocess.CalledProcessError) as error:
        print(f"prose_lint: {error}", file=sys.stderr)
        return 2
    for path in files:
        if not path.startswith(options.under) or path in OWN_TEXT:
            continue
        with open(f"{options.root}/{path}", encoding="utf-8") as file:
            source = file.read()
        code = ""
        if path.endswith(".md"):
            texts = markdown_texts(path, source)
            check_markdown_lines(path, source, report)
        elif path.endswith(".py"):
            texts, code = python_texts(path, source)
        else:
            texts, code = cpp_texts(path, source)
        for text in texts:
            prose = plain(text.text)
            check(text, prose, report)
            kind = "string" if text.kind == "test" else text.kind
            for sentence in sentence_end.split(prose):
                n = len(word_re.findall(sentence))
                if n >= 3:
                    lengths[kind] += 1
                    total_words[kind] += n
        if options.identifiers:
            for number, line in enumerate(code.split("\n"), 1):
                for word in name_re.findall(line):
                    for name, term in private_names(word):
                        by_name[name, term] += 1
                        report("identifier", path, number, f"{word} -> {term}", "code")
    if options.commits:
        for line in git(options.root, "log", "--format=%h %s", options.commits).split("\n")[:-1]:
            key, subject = line.split(" ", 1)
            faults = [f"{len(subject)} characters"] if len(subject) > MAX_SUBJECT else []
            faults += ["several subjects"] if ";" in subject else []
            faults += ["headless"] if HEADLESS.match(subject) or re.match(r"(?:A|An|The|Why|Six|Once)\b", subject) else []
            faults += [m.group(0) for rx, _, _ in private_re for m in [rx.search(subject)] if m]
            if faults:
                report("commit", f"commits/{key}", 0, f"{subject[:60]} ({', '.join(faults)})", "commit")

    rules = [*RULES, *(["identifier"] if options.identifiers else []), *(["commit"] if options.commits else [])]
    totals = {rule: sum(n for (r, f), n in counts.items() if r == rule and not f.startswith("kind:")) for rule in rules}
    folders = sorted({f for _, f in counts if not f.startswith("kind:")},
                     key=lambda f: -sum(counts[rule, f] for rule in rules))
    width = max([24, *map(len, folders)])
    print(f"{'folder':{width}s}" + "".join(f"{rule:>13s}" for rule in rules))
    for f in folders:
        print(f"{f:{width}s}" + "".join(f"{counts[rule, f]:13d}" for rule in rules))
    for kind in (*KINDS, "test"):
        print(f"{'of these: ' + kind:{width}s}" + "".join(f"{counts[rule, 'kind:' + kind]:13d}" for rule in rules))
    print(f"{'total':{width}s}" + "".join(f"{totals[rule]:13d}" for rule in rules))
    for kind in KINDS:
        if lengths[kind]:
            print(f"mean sentence, {kind}: {total_words[kind] / lengths[kind]:.1f} words of {lengths[kind]} sentences")
    if options.words:
        for (term, word), n in by_word.most_common():
            print(f"{n:6d} {word} -> {term}")
        for (name, term), n in by_name.most_common():
            print(f"{n:6d} {name} -> {term}")

    failed = False
    for limit in options.limit:
        rule, _, most = limit.rpartition("=")
        if rule and rule not in totals or not most.isdigit():
            print(f"prose_lint: --limit {limit}: use N or RULE=N, RULE one of {', '.join(rules)}", file=sys.stderr)
            return 2
        found = totals[rule] if rule else sum(totals.values())
        if found > int(most):
            print(f"prose_lint: {rule or 'total'}: {found}, allowed {most}", file=sys.stderr)
            failed = True
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
