"""Writes the MAT fixtures beside it. Needs numpy, scipy and h5py; the tests do not.

Value i of channel number c is ((7 i + 3 c) mod 13) / 4 + 100 c, which doubles hold exactly.
"""

import struct

import h5py
import numpy as np
import scipy.io
import scipy.sparse

N = 200


def channel(c, n=N):
    i = np.arange(n)
    return ((7 * i + 3 * c) % 13) / 4 + 100.0 * c


# ---- MAT v5 by SciPy ---------------------------------------------------------------

rig = {
    "t": np.arange(N, dtype=float),
    "FT1": channel(1),
    "PT1": channel(2),
    "pump": {"SPM": channel(3), "note": "triplex"},
    "units": {"t": "s", "FT1": "gpm", "PT1": "psi"},
}
both = {"gom": rig, "Ts": 4.0, "origin": "2015-06-01T00:00:00Z"}
for name, squash in [("struct_compressed", True), ("struct_plain", False)]:
    scipy.io.savemat(name + ".mat", both, do_compression=squash, oned_as="column")

kinds = {}
for name in ["i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8", "f4", "f8"]:
    kinds[{"i": "int", "u": "uint", "f": "float"}[name[0]] + str(8 * int(name[1]))] = (
        np.arange(10).astype(name)
    )
kinds["negative"] = np.array([-1, -2, -3], dtype="i2")
kinds["logical"] = np.array([True, False, True])
scipy.io.savemat("classes.mat", kinds, do_compression=True, oned_as="row")

cells = np.empty(3, dtype=object)
cells[:] = [channel(1, 5), "text", channel(2, 6)]
wells = np.zeros(2, dtype=[("depth", object), ("name", object)])
wells["depth"] = [channel(1, 4), channel(2, 4)]
wells["name"] = ["a", "b"]
odd = {
    "tall": np.stack([channel(1, 6), channel(2, 6)], axis=1),
    "wide": np.stack([channel(1, 6), channel(2, 6), channel(3, 6)], axis=0),
    "cube": np.zeros((2, 3, 4)),
    "none": np.zeros((0, 0)),
    "cplx": np.array([1 + 2j, 3 - 4j]),
    "thin": scipy.sparse.csc_matrix(np.eye(3)),
    "page": np.array(["two", "row"]),
    "cells": cells,
    "wells": wells,
}
scipy.io.savemat("odd.mat", odd, do_compression=False, oned_as="column")


# ---- MAT v5 by hand: both byte orders, doubles shrunk as MATLAB shrinks them ---------


class Writer:
    def __init__(self, order):
        self.order = order

    def element(self, kind, data):
        if 0 < len(data) <= 4:
            words = struct.pack(self.order + "I", len(data) << 16 | kind)
            return words + data.ljust(4, b"\0")
        return struct.pack(self.order + "II", kind, len(data)) + data + b"\0" * (-len(data) % 8)

    def matrix(self, flags, dims, name, body):
        inner = self.element(6, struct.pack(self.order + "II", flags, 0))
        inner += self.element(5, struct.pack(self.order + "%di" % len(dims), *dims))
        inner += self.element(1, name.encode()) + body
        return struct.pack(self.order + "II", 14, len(inner)) + inner

    def file(self, *variables):
        mark = struct.pack(self.order + "H", 0x0100) + struct.pack(self.order + "H", 0x4D49)
        return b"MATLAB 5.0 MAT-file, by hand".ljust(116) + bytes(8) + mark + b"".join(variables)


STORED = {1: "b", 2: "B", 3: "h", 4: "H", 5: "i", 6: "I", 7: "f", 9: "d", 12: "q", 13: "Q"}
for name, order in [("shrunk_little", "<"), ("shrunk_big", ">")]:
    w = Writer(order)
    out = []
    for kind, code in STORED.items():
        for n in [1, 2, 3, 9]:
            data = struct.pack(order + "%d%s" % (n, code), *range(5, 5 + n))
            out.append(w.matrix(6, [n, 1], "as%d_%d" % (kind, n), w.element(kind, data)))
    field = w.matrix(6, [3, 1], "", w.element(2, bytes([7, 8, 9])))
    text = w.matrix(4, [1, 3], "", w.element(4, struct.pack(order + "3H", *b"gpm")))
    names = w.element(5, struct.pack(order + "i", 8)) + w.element(1, b"FT1\0\0\0\0\0FT1_unit")
    out.append(w.matrix(2, [1, 1], "gom", names + field + text))
    with open(name + ".mat", "wb") as f:
        f.write(w.file(*out))

w = Writer("<")
table = w.element(6, struct.pack("<II", 17, 0)) + w.element(1, b"T") + w.element(1, b"MCOS")
table += w.element(1, b"table") + w.matrix(13, [6, 1], "", w.element(6, bytes(24)))
table = struct.pack("<II", 14, len(table)) + table
handle = w.matrix(16, [1, 1], "f", w.matrix(2, [1, 1], "", w.element(5, bytes(4))))
hidden = w.matrix(9, [1, 8], "", w.element(2, bytes(8)))
good = w.matrix(6, [2, 1], "good", w.element(9, struct.pack("<2d", 1.5, -2.5)))
with open("objects.mat", "wb") as f:
    f.write(w.file(table, handle, good, hidden))

# ---- MAT v7.3 ------------------------------------------------------------------------

HEADER = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, HDF5 schema 1.00 .".ljust(116)
HEADER += bytes(8) + b"\0\2IM"


def klass(thing, name):
    thing.attrs["MATLAB_class"] = np.bytes_(name)
    return thing


def column(group, name, values, **how):
    return klass(group.create_dataset(name, data=values[None, :], **how), "double")


def text(group, name, words):
    codes = np.array([[ord(c)] for c in words], dtype="u2")
    made = klass(group.create_dataset(name, data=codes), "char")
    made.attrs["MATLAB_int_decode"] = np.int32(2)


with h5py.File("struct73.mat", "w", userblock_size=512) as f:
    gom = klass(f.create_group("gom"), "struct")
    column(gom, "t", np.arange(N, dtype=float), chunks=(1, 64), compression="gzip")
    column(gom, "FT1", channel(1), chunks=(1, 64), compression="gzip")
    column(gom, "PT1", channel(2))
    column(klass(gom.create_group("pump"), "struct"), "SPM", channel(3))
    units = klass(gom.create_group("units"), "struct")
    for name, unit in [("t", "s"), ("FT1", "gpm"), ("PT1", "psi")]:
        text(units, name, unit)
    klass(f.create_dataset("Ts", data=np.array([[4.0]])), "double")
    text(f, "origin", "2015-06-01T00:00:00Z")
with open("struct73.mat", "r+b") as f:
    f.write(HEADER)

with h5py.File("odd73.mat", "w", userblock_size=512) as f:
    column(f, "good", channel(1, 5))
    flag = klass(f.create_dataset("flag", data=np.array([[1, 0, 1]], dtype="u1")), "logical")
    flag.attrs["MATLAB_int_decode"] = np.int32(1)
    # MATLAB's sides are the other way round: a tall 6 x 2 and a wide 3 x 6.
    klass(f.create_dataset("tall", data=np.stack([channel(1, 6), channel(2, 6)]), chunks=(1, 4)), "double")
    wide = np.stack([channel(c, 6) for c in [1, 2, 3]], axis=1)
    klass(f.create_dataset("wide", data=wide, chunks=(4, 2)), "double")
    klass(f.create_dataset("cube", data=np.zeros((2, 3, 4))), "double")
    none = klass(f.create_dataset("none", data=np.zeros(2, dtype="u8")), "double")
    none.attrs["MATLAB_empty"] = np.uint8(1)
    pair = np.dtype([("real", "f8"), ("imag", "f8")])
    klass(f.create_dataset("cplx", data=np.zeros((1, 3), dtype=pair)), "double")
    thin = klass(f.create_group("thin"), "double")
    thin.attrs["MATLAB_sparse"] = np.uint64(3)
    thin.create_dataset("data", data=np.ones(3))
    refs = f.create_group("#refs#")
    inner = column(refs, "a", channel(1, 4))
    cell = f.create_dataset("cells", data=np.array([[inner.ref]], dtype=h5py.ref_dtype))
    klass(cell, "cell")
    wells = klass(f.create_group("wells"), "struct")
    wells.create_dataset("depth", data=np.array([[inner.ref]], dtype=h5py.ref_dtype))
    f["alias"] = f["good"]
    f["soft"] = h5py.SoftLink("/good")
    f["lzf"] = np.zeros(1)
    del f["lzf"]
    f.create_dataset("lzf", data=channel(1), chunks=(64,), compression="lzf")
with open("odd73.mat", "r+b") as f:
    f.write(HEADER)

with h5py.File("plain.h5", "w") as f:
    rig = f.create_group("rig")
    for name in ["<i1", "<u1", "<i2", "<u2", "<i4", "<u4", "<i8", "<u8", "<f4", "<f8"]:
        rig.create_dataset(name[1:], data=np.arange(10).astype(name))
    for name in [">i2", ">u4", ">i8", ">f4", ">f8"]:
        rig.create_dataset(name[1:] + "_big", data=np.arange(10).astype(name))
    rig.create_dataset("flag", data=np.array([True, False]))
    rig["f8"].attrs["units"] = "gpm"
    rig["f4"].attrs["unit"] = np.bytes_("psi")
    rig.create_dataset("half", data=np.arange(3).astype("f2"))
    rig.create_dataset("part", shape=(40,), dtype="f8", chunks=(10,), fillvalue=-1.0)
    rig["part"][15] = 7.0
    rig.create_dataset(
        "checked", data=channel(5), chunks=(64,), compression="gzip", shuffle=True, fletcher32=True
    )

# More chunks than one node of their tree lists, and an old group of many names.
with h5py.File("tree.h5", "w") as f:
    f.create_dataset("many", data=channel(4, 150), chunks=(1,), maxshape=(None,))
    for c in range(40):
        f["many%02d" % c] = f["many"]
    ring = f.create_group("ring")
    ring["again"] = ring

with h5py.File("latest.h5", "w", libver="latest") as f:
    gom = f.create_group("gom")
    for c in range(1, 13):
        gom.create_dataset("CH%02d" % c, data=channel(c, 20))
    few = f.create_group("few")
    few.create_dataset("fixed", data=channel(1), chunks=(64,), compression="gzip", shuffle=True)
    few.create_dataset("single", data=channel(2), chunks=(N,), compression="gzip")
    few.create_dataset("bare", data=channel(3), chunks=(64,))
    few.create_dataset("grows", data=channel(4), chunks=(64,), maxshape=(None,))
    early = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    early.set_chunk((64,))
    early.set_alloc_time(h5py.h5d.ALLOC_TIME_EARLY)
    space = h5py.h5s.create_simple((N,))
    made = h5py.h5d.create(few.id, b"implicit", h5py.h5t.IEEE_F64LE, space, early)
    made.write(space, space, channel(5))
    few.create_dataset("compact", data=channel(6, 5))

# More chunks than one page of their list, and more names than one node of their index.
with h5py.File("paged.h5", "w", libver="latest") as f:
    f.create_dataset("pages", data=np.arange(1100).astype("u1"), chunks=(1,))
    crowd = f.create_group("crowd")
    for c in range(150):
        crowd["name%03d" % c] = f["pages"]
