"""The program that runs a Bladed-style controller library, in a process of its own: standard library only.

python bladed_worker.py LIBRARY PROCEDURE INPUT_FILE OUTPUT_ROOT LENGTH

From its standard input it takes swap arrays of LENGTH numbers (float32); to each it answers with the flag of the call
(int32), the length of the message (int32), the message and the swap array. One answer of flag 0 comes first, when the
library is loaded. What the library itself prints goes to the standard error.
"""

import ctypes
import os
import struct
import sys

MESSAGE_LENGTH = 1024


def main() -> None:
    """See above."""
    library, procedure, input_file, output_root, length = sys.argv[1:6]
    count = int(length)
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # a library that prints must not get between the answers
    questions = sys.stdin.buffer

    def answer(flag: int, message: bytes, swap: bytes) -> None:
        answers.write(struct.pack("ii", flag, len(message)) + message + swap)
        answers.flush()

    swap = (ctypes.c_float * count)()
    try:
        function = getattr(ctypes.CDLL(library), procedure)
    except (OSError, AttributeError) as error:
        answer(-1, str(error).encode(), bytes(swap))
        return
    function.restype = None
    answer(0, b"", bytes(swap))
    flag, message = ctypes.c_int(0), ctypes.create_string_buffer(MESSAGE_LENGTH)
    names = ctypes.create_string_buffer(input_file.encode()), ctypes.create_string_buffer(output_root.encode())
    size = ctypes.sizeof(swap)
    while len(content := questions.read(size)) == size:
        ctypes.memmove(swap, content, size)
        flag.value = 0
        message.value = b""
        function(swap, ctypes.byref(flag), *names, message)
        answer(flag.value, message.raw.partition(b"\0")[0].strip(), bytes(swap))


if __name__ == "__main__":
    main()
