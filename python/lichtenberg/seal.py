"""The checksum at the end of a result file, and checks before HDF5 opens the file (src/record/seal.hpp)."""
import mmap
import os
import struct
import zlib

from .errors import InputError

FOOTER = struct.Struct("<8sQII")  # mark, bytes before it, their CRC-32, 0
MAGIC = b"LICHTSUM"
HEAP = b"GCOL\1\0\0\0"  # signature and version of a collection in HDF5's global heap


def check_seal(path):
    """Whether the file ends with the checksum that its run gave it. Throws InputError if its bytes are not those of that
    checksum, or if something else follows the end of HDF5's bytes."""
    if not os.path.isfile(path) or os.path.getsize(path) < FOOTER.size:
        return False  # which opened() refuses
    try:
        with open(path, "rb") as file:
            length = file.seek(-FOOTER.size, os.SEEK_END)
            mark, count, crc, zero = FOOTER.unpack(file.read(FOOTER.size))
            if mark != MAGIC:
                trouble = beyond_end(file)
            else:
                right = (count, crc, zero) == (length, crc_of(file, length), 0)
                trouble = None if right else "its bytes are not those that were written: the checksum differs"
            if not trouble and has_endless_heap(path):
                trouble = "a collection of texts in it is broken"
    except OSError as error:
        raise InputError(f"{path} cannot be read ({error.strerror})") from None
    if trouble:
        raise InputError(f"{path} is damaged ({trouble})")
    return mark == MAGIC


def crc_of(file, count):
    """Returns the checksum of the first `count` bytes of a file."""
    crc, block = 0, 1 << 20
    file.seek(0)
    for begin in range(0, count, block):
        crc = zlib.crc32(file.read(min(block, count - begin)), crc)
    return crc


def has_endless_heap(path):
    """Returns true if HDF5 1.10 would traverse its global heap without end (src/record/global_heap.hpp)."""
    with open(path, "rb") as file, mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ) as data:
        begin = data.find(HEAP)
        while begin >= 0:
            size = int.from_bytes(data[begin + 8 : begin + 16], "little")
            if size > len(data) - begin:
                return True
            at = 16
            while at + 16 <= size:
                index, _, _, length = struct.unpack_from("<HHIQ", data, begin + at)
                step = 16 + (length + 7) // 8 * 8 if index else length  # the length of free space includes its header
                if step == 0 or step > size - at:
                    return True
                at += step
            begin = data.find(HEAP, begin + 1)
    return False


def beyond_end(file):
    """Returns an error message if a file without a seal has the wrong length, else None. HDF5's superblock states
    the length."""
    file.seek(0)
    head = file.read(52).ljust(52, b"\0")
    version = head[8]
    if not head.startswith(b"\x89HDF") or version > 3 or head[13 if version < 2 else 9] != 8:
        return None
    end = int.from_bytes(head[(at := (40, 44, 28, 28)[version]) : at + 8], "little")
    size = file.seek(0, os.SEEK_END)
    return None if size == end else "its end is missing" if size < end else "the checksum at its end is damaged"
