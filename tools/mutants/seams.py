"""Writes many mutants into one source text, so that a number chooses the active one when the program runs.

`a < b` with the mutants 17 and 18 is written as

    (match crate::mutant([17, 18]) { 0 => (a < b), 1 => (a <= b), _ => (a > b) })

Only one mutant is active at a time. So the texts of the mutants contain no other mutant, and the first arm contains all
that are nested. Each mutant has lines of its own: an error of the compiler names its mutant by its line.
"""

import re
from dataclasses import dataclass, field

from rust_expressions import Source, Unsupported

MODULE = """
pub(crate) use mutant_choice::mutant;
mod mutant_choice {
    use std::io::Write;
    use std::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};
    const UNKNOWN: u32 = u32::MAX;
    const RECORDING: u32 = u32::MAX - 1;
    static ACTIVE: AtomicU32 = AtomicU32::new(UNKNOWN);
    static REACHED: [AtomicBool; %(count)s] = [const { AtomicBool::new(false) }; %(count)s];
    /// The place of the active mutant among these, from 1, or 0. REVPRIO_MUTANT is the number of the active one.
    /// REVPRIO_MUTANTS_REACHED names a file for the numbers of all that are asked for.
    #[inline]
    pub(crate) fn mutant<const K: usize>(numbers: [u32; K]) -> usize {
        let active = ACTIVE.load(Relaxed);
        if active >= RECORDING {
            return start(&numbers);
        }
        numbers.iter().position(|&number| number == active).map_or(0, |place| place + 1)
    }
    #[cold]
    fn start(numbers: &[u32]) -> usize {
        if let Ok(path) = std::env::var("REVPRIO_MUTANTS_REACHED") {
            ACTIVE.store(RECORDING, Relaxed);
            for &number in numbers {
                if !REACHED[number as usize].swap(true, Relaxed) {
                    let file = std::fs::File::options().append(true).create(true).open(&path);
                    file.and_then(|mut file| file.write_all(format!("{number}\\n").as_bytes())).unwrap();
                }
            }
            return 0;
        }
        let chosen = std::env::var("REVPRIO_MUTANT").map_or(0, |text| text.parse().unwrap());
        ACTIVE.store(chosen, Relaxed);
        numbers.iter().position(|&number| number == chosen).map_or(0, |place| place + 1)
    }
}
"""


@dataclass
class Seam:
    """A part of the text that one or more mutants change. `alternatives`: number → text in its place."""

    start: int
    end: int
    kind: str
    alternatives: dict = field(default_factory=dict)


def offset_of(lines, place):
    return lines[place["line"] - 1] + place["column"] - 1


def seam_of(source, lines, mutant):
    """Returns the seam of a mutant and its text."""
    span, new = mutant["span"], mutant["replacement"]
    start, end = offset_of(lines, span["start"]), offset_of(lines, span["end"])
    text, genre = source.text, mutant["genre"]
    if genre == "FnValue":
        if "impl " in (mutant["function"]["return_type"] or ""):
            raise Unsupported("returns another type")
        return Seam(start, start, "body"), new
    if genre == "MatchArmGuard":
        return Seam(start, end, "expression"), new
    if genre == "MatchArm":
        arrow, guard = source.arm_arrow(start)
        return Seam(guard or arrow, arrow, "arm"), new
    if genre == "StructField":
        first, last = source.struct_literal(start)
        comma = re.match(r"\s*,", text[end:])
        cut = end + (comma.end() if comma else 0)
        return Seam(first, last, "expression"), text[first:start] + text[cut:last]
    first, last = source.unary(start) if genre == "UnaryOperator" else source.binary(start, new)
    return Seam(first, last, "expression"), text[first:start] + new + text[end:last]


def write_seams(text, mutants, unviable):
    """Returns the text with the mutants (number → mutant), the mutant of each line, and why others are left out."""
    source = Source(text)
    lines = [0] + [m.end() for m in re.finditer("\n", text)]
    seams, left_out = {}, {}
    for number, mutant in mutants.items():
        if number in unviable:
            continue
        try:
            seam, new = seam_of(source, lines, mutant)
        except (Unsupported, KeyError, IndexError) as reason:
            left_out[number] = str(reason)
            continue
        seams.setdefault((seam.start, seam.end, seam.kind), seam).alternatives[number] = new
    # Outer seams come first; at one place the body begins before its first expression.
    order = sorted(seams.values(), key=lambda seam: (seam.start, seam.kind != "body", -seam.end))
    pieces = _written(text, 0, len(text), order)
    out, owner, line = [], {}, 1
    for piece, number in pieces:
        for at in range(line, line + piece.count("\n") + 1):
            if number is not None:
                owner[at] = number
        line += piece.count("\n")
        out.append(piece)
    return "".join(out), owner, left_out


def _written(text, start, end, seams):
    """Yields (text, number of the mutant that it belongs to or None) for a part of the text."""
    at = start
    while seams:
        seam, rest = seams[0], seams[1:]
        inner = [other for other in rest if other.end <= seam.end and seam.kind != "body" and other.start >= seam.start]
        seams = [other for other in rest if other not in inner]
        yield text[at : seam.start], None
        at = seam.end
        numbers = ", ".join(map(str, seam.alternatives))
        arms = [str(place) for place in range(1, len(seam.alternatives))] + ["_"]
        if seam.kind == "body":
            yield f"match crate::mutant([{numbers}]) {{\n0 => {{}}\n", None
            for arm, (number, new) in zip(arms, seam.alternatives.items()):
                yield f"{arm} => return {new},", number
                yield "\n", None
            yield "}\n", None
        elif seam.kind == "arm":
            has_guard = seam.start != seam.end
            yield f" {'' if has_guard else 'if '}crate::mutant([{numbers}]) == 0", None
            if has_guard:
                yield " && (", None
                yield from _written(text, seam.start, seam.end, inner)
                yield ")", None
            yield " ", None
        else:
            yield f"(match crate::mutant([{numbers}]) {{ 0 => (", None
            yield from _written(text, seam.start, seam.end, inner)
            yield "),\n", None
            for arm, (number, new) in zip(arms, seam.alternatives.items()):
                yield f"{arm} => ({new}),", number
                yield "\n", None
            yield "})", None
    yield text[at:end], None
