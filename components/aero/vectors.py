"""C text in vectors: once for each width of those of gcc and clang that a processor may have, chosen when it runs."""

from __future__ import annotations

from fowtlib.language.processor import lanes_here, processor_text

WIDTHS = {8: "avx512f,avx512dq,avx512vl,avx2,fma", 4: "avx2,fma", 2: ""}
"""Lanes, and what the processor must have: the first two x86-64 alone, two lanes every processor of 64 bits."""

_BEGIN = """
#ifdef __clang__
#pragma clang fp contract(fast)
{clang}#else
#pragma GCC push_options
#pragma GCC optimize("fp-contract=fast")
{gcc}#endif
"""
_END = """
#ifdef __clang__
#pragma clang fp contract(off)
{clang}#else
#pragma GCC pop_options
#endif
"""


def in_vectors(text: str) -> str:
    """The text for each width, with LANES and LANE(name), a name of its own; in front of it what processor.c gives.

    A product and a sum may become one operation, rounded once, in this text and nowhere else. The text itself says so,
    and no flag for a compiler or linker, which could change how the processor rounds for others. Where ONLY_LANES is
    defined in front of it, that width is compiled alone; see `only_lanes`.
    """
    parts = [processor_text()]
    for lanes, target in WIDTHS.items():
        pushed = popped = asked = ""
        if target:
            pushed = f'#pragma clang attribute push(__attribute__((target("{target}"))), apply_to = function)\n'
            popped, asked = "#pragma clang attribute pop\n", f'#pragma GCC target("{target}")\n'
        parts += [
            f"#if defined(VECTORS){' && defined(__x86_64__)' if target else ''}",
            f" && (!defined(ONLY_LANES) || ONLY_LANES == {lanes})\n",
            f"#define LANES {lanes}\n#define LANE(name) name##_{lanes}\n",
            _BEGIN.format(clang=pushed, gcc=asked), text, _END.format(clang=popped),
            "#undef LANES\n#undef LANE\n#endif\n",
        ]  # fmt: skip
    return "".join(parts)


def only_lanes(nodes: int) -> str:
    """In front of a text that goes through so many nodes and is compiled for this machine: the one width it can use.

    Each width takes as long to compile as all the rest.
    """
    lanes = lanes_here()
    while lanes > nodes:
        lanes //= 2
    return f"#define ONLY_LANES {lanes}\n"
