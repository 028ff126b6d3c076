"""The extent of a Rust expression around an operator, found from tokens. Enough for the code of this repository.

`Source` splits a text into tokens. Brackets, and the angle brackets after `::`, know their partner. The functions return
offsets in the text. `Unsupported` means that the form of the expression is not known here.
"""

import re
from bisect import bisect_left

TOKEN = re.compile(
    r"(?P<space>\s+|//[^\n]*|/\*.*?\*/)"
    r'|(?P<text>b?r#".*?"#|b?"(?:\\.|[^"\\])*"|b?\'(?:\\.[^\']*|[^\'\\])\')'
    r"|(?P<lifetime>'\w+)"
    r"|(?P<number>\d[\d_]*(?:\.\d[\d_]*(?:[eE][+-]?\d+)?|\.(?![.\w])|[eE][+-]?\d+)?\w*)"
    r"|(?P<word>\w+)"
    r"|(?P<sign>\.\.=|<<=|>>=|\.\.|::|=>|->|==|!=|<=|>=|&&|\|\||[-+*/%^&|]=|.)",
    re.DOTALL,
)
PRECEDENCE = {"as": 12, "*": 11, "/": 11, "%": 11, "+": 10, "-": 10, "&": 8, "^": 7}
PRECEDENCE |= dict.fromkeys(["==", "!=", "<", ">", "<=", ">="], 5) | {"&&": 4, "||": 3}
ASSIGNMENTS = ["+=", "-=", "*=", "/=", "%=", "&=", "|=", "^="]
KEYWORDS = set("as break else for if in let loop match move mut ref return unsafe while where".split())
CLOSING = {"(": ")", "[": "]", "{": "}"}


class Unsupported(Exception):
    """The form of the expression is not known here."""


class Source:
    """The tokens of a text."""

    def __init__(self, text):
        self.text = text
        self.tokens, self.starts, self.ends = [], [], []
        self.partner = {}
        at = 0
        while at < len(text):
            match = TOKEN.match(text, at)
            token, kind = match.group(), match.lastgroup
            if kind == "number" and self.tokens and self.tokens[-1] == ".":
                token = re.match(r"\d+", token).group()  # The field of a tuple.
            if kind != "space":
                self.tokens.append(token)
                self.starts.append(at)
                self.ends.append(at + len(token))
            at += len(token)
        self._pair()

    def _pair(self):
        opened = []
        for i, token in enumerate(self.tokens):
            if token in CLOSING or (token == "<" and i > 0 and self.tokens[i - 1] == "::"):
                opened.append(i)
            elif token == "<" and opened and self.tokens[opened[-1]] == "<":
                opened.append(i)
            elif token in (")", "]", "}") or (token == ">" and opened and self.tokens[opened[-1]] == "<"):
                first = opened.pop()
                self.partner[i], self.partner[first] = first, i

    def index(self, offset):
        """Returns the token that begins at an offset."""
        i = bisect_left(self.starts, offset)
        if i == len(self.starts) or self.starts[i] != offset:
            raise Unsupported("no token begins here")
        return i

    def token(self, i):
        return self.tokens[i] if 0 <= i < len(self.tokens) else ""

    def ends_operand(self, i):
        """Returns whether an operand can end with a token, so that an operator after it is a binary one."""
        token = self.token(i)
        if token in (")", "]", "}", "?") or (token == ">" and i in self.partner):
            return True
        return bool(token) and (token[0].isalnum() or token[0] in "_\"'") and token not in KEYWORDS

    def binary(self, offset, replacement):
        """Returns the extent of the expression whose binary or assigning operator is at an offset.

        It contains the neighbours that bind as strongly as the old operator or its replacement: a * b * c with + in the first
        place is a + b * c.
        """
        i = self.index(offset)
        operator = self.tokens[i]
        if operator in ASSIGNMENTS:
            first, last = self._operand_before(i), i + 1
            while self.tokens[last] not in (";", ",", ")", "]", "}"):
                last = self.partner.get(last, last) + 1
            return self.starts[first], self.ends[last - 1]
        strength = min(PRECEDENCE[operator], PRECEDENCE[replacement])
        first = self._operand_before(i)
        while self.ends_operand(first - 2) and PRECEDENCE.get(self.token(first - 1), 0) >= strength:
            first = self._operand_before(first - 1)
        last = self._operand_after(i)
        while PRECEDENCE.get(self.token(last + 1), 0) > strength:
            last = self._operand_after(last + 1)
        return self.starts[first], self.ends[last]

    def unary(self, offset):
        """Returns the extent of the expression whose prefix operator is at an offset."""
        i = self.index(offset)
        return self.starts[i], self.ends[self._operand_after(i)]

    def struct_literal(self, offset):
        """Returns the extent of the struct literal that has a field at an offset."""
        i = self.index(offset) - 1
        while self.tokens[i] != "{" or i not in self.partner:
            i = self.partner[i] - 1 if self.tokens[i] in (")", "]", "}") else i - 1
        return self.starts[self._path_before(i - 1)], self.ends[self.partner[i]]

    def arm_arrow(self, offset):
        """Returns the offset of the `=>` of the match arm that begins at an offset, and that of its guard or None."""
        i, guard = self.index(offset), None
        while self.tokens[i] != "=>":
            if self.tokens[i] == "if":
                guard = self.ends[i]
            i = self.partner.get(i, i) + 1 if self.tokens[i] in CLOSING else i + 1
        return self.starts[i], guard

    def _path_before(self, i):
        """Returns the first token of the path that ends with token i."""
        while True:
            if self.tokens[i] == ">" and i in self.partner:
                i = self.partner[i] - 2  # The name before `::<`.
            if self.token(i - 1) != "::":
                return i
            i -= 2

    def _operand_before(self, operator):
        """Returns the first token of the operand with its prefix operators that ends before an operator."""
        i = operator - 1
        while True:
            token = self.tokens[i]
            if not self.ends_operand(i):
                raise Unsupported(f"operand ends with {token}")
            if token == "}":
                return self._block_before(i)
            if token == "?":
                i -= 1
                continue
            if token in (")", "]"):
                i = self.partner[i]
                if self.token(i - 1) == "!" and self.ends_operand(i - 2):
                    i = self._path_before(i - 2)  # A macro.
                elif self.ends_operand(i - 1) and self.token(i - 1) != "}":
                    i -= 1
                    continue
            else:
                i = self._path_before(i)
            if self.token(i - 1) != ".":
                break
            i -= 2
        while self.token(i - 1) in ("-", "!", "*", "&", "mut") and not self.ends_operand(i - 2):
            i -= 1
        return i

    def _operand_after(self, operator):
        """Returns the last token of the operand with its prefix operators that begins after an operator."""
        i = operator + 1
        while self.tokens[i] in ("-", "!", "*", "&", "mut"):
            i += 1
        if self.tokens[i] == "if":
            return self._branches(i)
        if self.tokens[i] in KEYWORDS or self.tokens[i] in ("{", "|", "||"):
            raise Unsupported(f"operand begins with {self.tokens[i]}")
        i = self.partner.get(i, i)
        while True:
            following = self.token(i + 1)
            if following == "?":
                i += 1
            elif following == "." or (following == "::" and self.token(i + 2) != "<"):
                i += 2
            elif following == "::":
                i = self.partner[i + 2]
            elif following in ("(", "["):
                i = self.partner[i + 1]
            elif following == "!" and self.token(i + 2) in CLOSING:
                i = self.partner[i + 2]
            else:
                return i

    def _block_before(self, i):
        """Returns the `if` of the expression whose last branch ends with token i."""
        while self.token(self.partner[i] - 1) == "else":
            i = self.partner[i] - 2
        i = self.partner[i] - 1
        while self.token(i) not in ("if", ";", "{", ","):
            i = self.partner.get(i, i) - 1
        if self.token(i) != "if":
            raise Unsupported("operand ends with a block")
        return i

    def _branches(self, i):
        """Returns the last token of `if a { b } else { c }` that begins at token i."""
        while True:
            while self.tokens[i] != "{":
                i = self.partner.get(i, i) + 1
            i = self.partner[i]
            if self.token(i + 1) != "else":
                return i
            i += 2
