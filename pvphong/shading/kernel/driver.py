"""One block of vertices after the other through the stages that its equation calls for.

The equation comes as records, so that its values are arguments of compiled code: moving or tinting a light
compiles nothing. What the driver branches on, it branches on once per block. It knows no light and no reflectance:
theirs are the stages, called through pointers, once per block and light. What it knows is what all of them share:
a light that is the same everywhere, and Lambert's factor, which it adds without writing it down first.
"""

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import carray
from numba.core import types
from numba.extending import intrinsic

from pvphong.shading.kernel import colors, vertices
from pvphong.shading.kernel import vertices as at
from pvphong.shading.kernel.arithmetic import (
    call_light,
    call_reflectance,
    inlined,
    like,
    nowhere,
    pasted,
    shifted,
    taken,
)
from pvphong.shading.kernel.vertices import AT_WORK, BEGUN, BLOCK, GROUP, LEFT, LINE, in_type

# Memory for the next block is asked for while this one's lights are computed: a processor guesses how a stream goes on
# only while it is being read, and a block is read and written in bursts with much arithmetic between them. It can wait
# for some two dozen cache lines at once, which is one array's share of a block in float32; so each light goes with one
# array, and what is written first, because it is waited for longest.


def _prefetch(for_writing: int) -> Any:
    """Compiled code that asks for the cache lines of a block's vectors; LLVM's hint, which never fails."""

    @intrinsic
    def prefetch(_typing: Any, array: Any, first: Any) -> Any:  # noqa: ARG001 Numba wants it by name
        size = array.dtype.bitwidth // 8

        def generate(context: Any, builder: Any, _signature: Any, arguments: Any) -> Any:
            array, first = arguments
            byte, i32 = ir.IntType(8).as_pointer(), ir.IntType(32)
            kind = ir.FunctionType(ir.VoidType(), [byte, i32, i32, i32])
            function = builder.module.declare_intrinsic("llvm.prefetch", [byte], kind)
            start = builder.bitcast(builder.gep(array, [builder.mul(first, first.type(3))]), byte)
            for offset in range(0, 3 * BLOCK * size, LINE):
                line = builder.gep(start, [first.type(offset)])
                builder.call(function, [line, i32(for_writing), i32(3), i32(1)])  # into the nearest cache, of data
            return context.get_dummy_value()

        return types.void(array, types.intp), generate

    return prefetch


_to_read, _to_write = _prefetch(0), _prefetch(1)


@inlined
def _prefetch_block(turn: int, first: int, points: Any, normals: Any, rgb: Any, display: Any, s: Any) -> None:
    """Ask for the block that begins with vertex `first`: its colours at turn 0, its normals at 1, its points at 2."""
    if turn == 0:
        if s.is_display:
            _to_write(display, first)
        else:
            _to_write(rgb, first)
    elif turn == 1:
        if s.needs_normals:
            _to_read(normals, first)
    elif turn == 2 and s.needs_points:
        _to_read(points, first)


@pasted
def _load_normals(array: Any, start: int, count: int, s: Any, rows: Any, wide: Any) -> bool:
    """Normals into their rows; whether none is declined."""
    if s.turns_normals:
        vertices.split(array, start, count, wide)
        vertices.rotate_normals(s.normal_matrix, wide, rows)
    else:
        vertices.split(array, start, count, shifted(rows, at.NX))
    if vertices.measure_normals(rows):
        return True
    vertices.split(array, start, count, wide)
    good = vertices.scale_normals(wide, s.normal_matrix, s.turns_normals, rows)
    vertices.measure_normals(rows)
    return good


@pasted
def _look(s: Any, rows: Any, points: Any) -> bool:
    """Directions to the viewer, and normals turned to it; whether no vertex is declined."""
    good = True
    if s.needs_eye:
        good = vertices.approach(rows, points, s.eye[0], s.eye[1], s.eye[2])
        vertices.look(rows)
    if s.is_flipped:
        vertices.turn_normals(rows, not s.has_local_facing)
    if s.has_lobes_of_viewer:
        vertices.face(rows)
    return good


@pasted
def _add_lambert(t: Any, varies: bool, gain: Any, rows: Any) -> None:
    """Add the light of one of which Lambert's factor alone is wanted."""
    red, green, blue = in_type(t.colors[0], rows)
    if t.is_even and varies:
        colors.add_parallel_weakened(rows, red, green, blue, *in_type(t.way, rows))
    elif t.is_even:
        colors.add_parallel(rows, red, green, blue, *in_type(t.way, rows))
    elif varies:
        colors.add_weakened(rows, gain, red, green, blue)
    else:
        colors.add_lambert(rows, red, green, blue)


@pasted
def _add_lobes(t: Any, s: Any, reflected: int, varies: bool, gain: Any, rows: Any) -> None:
    """Add the light of one whose lobes' factors stand in their rows; those that are 0 everywhere are left out."""
    if varies:
        for lobe in range(3):
            if reflected & (1 << lobe):
                colors.weaken(rows, at.FIRST + lobe * BLOCK, gain)
    if not s.has_albedo and reflected == 7:
        colors.add_three(rows, *in_type(t.colors[0], rows), *in_type(t.colors[1], rows), *in_type(t.colors[2], rows))
        return
    if not s.has_albedo and reflected & 3 == 3:
        colors.add_two(rows, *in_type(t.colors[0], rows), *in_type(t.colors[1], rows))
        reflected &= ~3
    for lobe in range(3):
        if reflected & (1 << lobe):
            target = at.HR if s.has_albedo and not s.takes_albedo & (1 << lobe) else at.R
            colors.add_lobe(rows, at.FIRST + lobe * BLOCK, target, *in_type(t.colors[lobe], rows))


@pasted
def _add_ambient(t: Any, s: Any, rows: Any) -> None:
    """Add what a light adds whatever the normal."""
    color, gain = in_type(t.ambient, rows), like(rows, t.gain)
    if s.sky < 0:
        if t.varies:
            colors.add_strength(rows, gain, *color)
        else:
            colors.add_evenly(rows, *color)
    elif t.varies:
        colors.add_strength_under_sky(rows, gain, *color)
    else:
        colors.add_sky(rows, *color)


@pasted
def _add_light(
    first: int, count: int, channels: Any, t: Any, s: Any, numbers: Any, own: Any, rows: Any, points: Any
) -> bool:
    """Add one light; whether no vertex is declined."""
    good = True
    if not t.is_even:
        good = call_light(t.arrives, own, rows, points)
        if t.has_ambient:
            _add_ambient(t, s, rows)
    if not t.wanted:
        return good
    varies, gain = t.varies, like(rows, t.gain)
    if t.visible >= 0:
        vertices.take(shifted(channels, t.visible * s.channel_length), first, count, shifted(rows, at.VISIBLE))
        colors.block(rows, gain, varies)
        varies, gain = True, like(rows, 1.0)
    if not t.reflects:
        _add_lambert(t, varies, gain, rows)
        return good
    if t.is_even:
        colors.fill(rows, at.DX, *in_type(t.way, rows))
        vertices.measure_differences(rows)
    _add_lobes(t, s, t.wanted & call_reflectance(t.reflects, numbers, rows, points), varies, gain, rows)
    return good


@pasted
def _light(
    first: int,
    count: int,
    points: Any,
    normals: Any,
    albedo: Any,
    channels: Any,
    rgb: Any,
    display: Any,
    s: Any,
    terms: Any,
    numbers: Any,
    rows: Any,
    wide: Any,
) -> bool:
    """Colours of one block's vertices, in its rows; whether no vertex is declined."""
    good = True
    if s.needs_normals:
        good = _load_normals(normals, first, count, s, rows, wide) & good
    places = nowhere(wide)
    if s.is_wide:
        places = wide
        vertices.split(points, first, count, wide)
        if s.moves_points:
            vertices.transform(s.matrix, s.w, wide)
    elif s.needs_points:
        vertices.split(points, first, count, shifted(rows, at.PX))
    good = _look(s, rows, places) & good
    if s.tangents >= 0:
        for axis in range(3):
            channel = shifted(channels, (s.tangents + axis) * s.channel_length)
            vertices.take(channel, first, count, shifted(rows, at.TX + axis * BLOCK))
        vertices.straighten_tangents(rows)
    if s.sky >= 0:
        vertices.take(shifted(channels, s.sky * s.channel_length), first, count, shifted(rows, at.SKY))
        colors.fill_under_sky(rows, *in_type(s.base, rows), *in_type(s.own, rows))
    else:
        colors.fill(rows, at.R, *in_type(s.base, rows))
    if s.has_albedo:
        colors.fill(rows, at.HR, *in_type(s.emission, rows))
    for turn in range(len(terms)):
        _prefetch_block(turn, first + BLOCK, points, normals, rgb, display, s)
        own = shifted(numbers, (turn + 1) * s.stride)
        good = _add_light(first, count, channels, terms[turn], s, numbers, own, rows, places) & good
    if s.has_albedo:
        vertices.split(albedo, first, count, shifted(rows, at.ALBEDO_R))
        colors.tint(rows)
    if s.exponent != 1.0:
        colors.encode(rows, like(rows, s.exponent))
    return good


@pasted
def _store(first: int, count: int, rgb: Any, display: Any, s: Any, rows: Any) -> None:
    """Colours from one block's rows to where they are wanted."""
    if s.is_display:
        colors.join_bytes(rows, display, first, count)
    else:
        colors.join(rows, like(rows, s.low), like(rows, s.high), rgb, first, count)


@pasted
def _light_group(
    start: int,
    stop: int,
    points: Any,
    normals: Any,
    albedo: Any,
    channels: Any,
    rgb: Any,
    display: Any,
    s: Any,
    terms: Any,
    numbers: Any,
    rows: Any,
    wide: Any,
    declined: Any,
) -> bool:
    """Light vertices from `start` up to `stop`; whether none is declined, else each one is noted."""
    none = True
    for first in range(start, stop, BLOCK):
        count = min(stop - first, BLOCK)
        if s.is_sunlit and count == BLOCK and colors.shine_on(normals, first, s, terms[0], rgb):
            continue
        is_like_first = s.is_even and first != start
        if is_like_first or _light(
            first, count, points, normals, albedo, channels, rgb, display, s, terms, numbers, rows, wide
        ):
            _store(first, count, rgb, display, s, rows)
            continue
        none = False
        for i in range(count):
            declined[first - start + i] = rows[at.DECLINED + i] != 0.0
        vertices.unmark(rows)
        _store(first, count, rgb, display, s, rows)
    return none


def shade(
    points: Any,
    normals: Any,
    albedo: Any,
    channels: Any,
    rgb: Any,
    display: Any,
    settings: Any,
    terms: Any,
    numbers: Any,
    shared: Any,
    threads: int,
    own: int,
    patience: int,
    count: int,
    rows: Any,
    wide: Any,
    declined: Any,
) -> int:
    """Light group after group until none is left, or a vertex is declined: then gives its group's first, else -1.

    Several threads may do so at once with one `shared`. Each begins with a range of its own, for threads that write to
    one page of memory that is new wait for each other, and then helps the others out.

    Parameters
    ----------
    points, normals, albedo
        Vectors of all vertices one after the other; what is not needed may be anything.
    channels
        Single numbers of all vertices, channel after channel: what of lights and of the sky they see.
    rgb, display
        Where the colours go: floats, or bytes if `is_display`.
    settings, terms, numbers
        The equation, as `records` has it.
    shared
        `BEGUN` numbers and one for each range, 0 at first.
    threads, own : int
        How many ranges there are, and which is this thread's.
    patience : int
        How often to look, in the end, whether other threads are still at work, before it is left to the caller to wait
        for them: sleeping and waking takes longer than most have left to do.
    count : int
        Of vertices.
    rows, wide
        Scratch memory: `ROWS` numbers, and 3 · `BLOCK` of float64.
    declined
        A byte for each vertex of a group, 0; becomes 1 for those that the reference has to light.
    """
    s = carray(settings, (1,))[0]
    lights = carray(terms, (s.count,))
    vertices.unmark(rows)
    colors.fill(rows, at.VX, *in_type(s.to_eye, rows))
    colors.fill(rows, at.AX, *in_type(s.to_eye, rows))
    at_work, left = shifted(shared, AT_WORK), -1
    taken(at_work, 1)
    length = (count + threads * GROUP - 1) // (threads * GROUP) * GROUP
    for turn in range(threads):
        here = (own + turn) % threads
        begun, end = shifted(shared, BEGUN + here), min((here + 1) * length, count)
        start = here * length + taken(begun, GROUP)
        while start < end and left < 0:
            stop = min(start + GROUP, end)
            if not _light_group(
                start, stop, points, normals, albedo, channels, rgb, display, s, lights, numbers, rows, wide, declined
            ):
                left = start
                taken(shifted(shared, LEFT), 1)
            else:
                start = here * length + taken(begun, GROUP)
        if left >= 0:
            break
    taken(at_work, -1)
    while patience > 0 and taken(at_work, 0) > 0:
        patience -= 1
    return left
