"""C text in vectors: once for each width of those of gcc and clang that a processor may have, chosen when it runs."""

from __future__ import annotations

WIDTHS = {8: "avx512f,avx512dq,avx512vl,avx2,fma", 4: "avx2,fma", 2: ""}
"""Lanes, and what the processor must have: the first two x86-64 alone, two lanes every processor of 64 bits."""

# gcc for Windows keeps too few bytes of the stack aligned for wide vectors; other compilers have other vectors
_HEAD = """
#if defined(__GNUC__) && (defined(__x86_64__) || defined(__aarch64__)) && !(defined(_WIN32) && !defined(__clang__))
#define VECTORS
#endif
"""


def in_vectors(text: str) -> str:
    """The text for each width, with LANES and LANE(name), a name of its own; VECTORS is defined where there are any.

    A product and a sum may become one operation, rounded once, here and nowhere else: that is said in the text, so that
    neither the flags of the compiler nor the state of the processor change.
    """
    parts = [_HEAD]
    for lanes, target in WIDTHS.items():
        pushed = f'#pragma clang attribute push(__attribute__((target("{target}"))), apply_to = function)\n'
        asked = f'#pragma GCC target("{target}")\n'
        parts += [
            "#ifdef VECTORS\n" if lanes == 2 else "#if defined(VECTORS) && defined(__x86_64__)\n",
            f"#define LANES {lanes}\n#define LANE(name) name##_{lanes}\n",
            f"#ifdef __clang__\n#pragma clang fp contract(fast)\n{pushed if target else ''}",
            f'#else\n#pragma GCC push_options\n#pragma GCC optimize("fp-contract=fast")\n{asked if target else ""}#endif\n',
            text,
            "\n#ifdef __clang__\n#pragma clang fp contract(off)\n",
            f"{'#pragma clang attribute pop' if target else ''}\n#else\n#pragma GCC pop_options\n#endif\n",
            "#undef LANES\n#undef LANE\n#endif\n",
        ]
    return "".join(parts)
