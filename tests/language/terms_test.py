"""Tests of docs/developers/terms.md: form of the rows, files and identifiers, terms in comments of the code."""
import re
import unittest
from pathlib import Path

HOME = Path(__file__).resolve().parents[2]
PAGE = HOME / "docs/developers/terms.md"
MAX_WORDS, MAX_ROW_WORDS = 1300, 12
MIN_ROWS, MAX_ROWS = 130, 170
MIN_TERMS_IN_COMMENTS = 120
LOCATION = r"`[\w~]+`, `[\w./-]+`"
TERM = r"(?P<term>[^|(]+?)(?: \([^|()]+\))?"
ROW = re.compile(rf"\|{TERM}\|(?P<where>(?:not (?:computed|used); )?{LOCATION}(?:; {LOCATION})*)\|")


def rows():
    """Returns the rows of all tables, without head and separator."""
    lines = [line for line in PAGE.read_text().splitlines() if line.startswith("|")]
    return [line for line in lines if line not in ("|term (synonyms)|where|", "|-|-|")]


def entries():
    """Returns (term, list of (identifier, path)) of each row that has the form of ROW."""
    found = [match for match in map(ROW.fullmatch, rows()) if match]
    return [(match["term"], re.findall(r"`([^`]+)`, `([^`]+)`", match["where"])) for match in found]


def comment_lines():
    """Returns the comments of .hpp and .cpp files in src and solvers, line by line, in lower case."""
    paths = [path for folder in ("src", "solvers") for path in (HOME / folder).rglob("*.[hc]pp")]
    return re.findall(r"(?<!:)//(.*)", "\n".join(path.read_text() for path in paths).lower())


class Page(unittest.TestCase):
    def test_each_row_has_the_form_of_the_table(self):
        for row in rows():
            with self.subTest(row):
                self.assertTrue(ROW.fullmatch(row), "not of the form |term (synonyms)|`identifier`, `file`|")
                self.assertLessEqual(len(row.split()), MAX_ROW_WORDS)

    def test_each_term_has_one_row(self):
        terms = [term.lower() for term, _ in entries()]
        self.assertEqual(sorted(terms), sorted(set(terms)))

    def test_the_page_is_short(self):
        self.assertTrue(MIN_ROWS <= len(rows()) <= MAX_ROWS, len(rows()))
        self.assertLessEqual(len(PAGE.read_text().split()), MAX_WORDS)


class Code(unittest.TestCase):
    def test_each_file_contains_its_identifier(self):
        for term, locations in entries():
            for identifier, name in locations:
                with self.subTest(f"{term}: {identifier}, {name}"):
                    path = HOME / name
                    self.assertTrue(path.is_file(), "no such file")
                    self.assertRegex(path.read_text(), rf"\b{re.escape(identifier)}\b")

    def test_terms_are_in_comments(self):
        """A line of a comment must contain the whole term, so that grep finds it."""
        comments = "\n".join(comment_lines())
        found = [term for term, _ in entries() if term.lower() in comments]
        self.assertGreaterEqual(len(found), MIN_TERMS_IN_COMMENTS)


if __name__ == "__main__":
    unittest.main()
