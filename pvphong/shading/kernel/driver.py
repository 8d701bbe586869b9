"""One block of vertices after the other through the stages that its equation calls for.

The equation comes as records, so that its values are arguments of compiled code: moving or tinting a light
compiles nothing. What the driver branches on, it branches on once per block. It knows no light and no reflectance:
theirs are the stages, called through pointers, once per block and light. What it knows is what all of them share:
a light that is the same everywhere, and Lambert's factor, which it adds without writing it down first.
"""

from __future__ import annotations

from typing import Any

from numba import carray

from pvphong.shading.kernel import adding, colors, loading, prefetch, sunlight, ways
from pvphong.shading.kernel import rows as at
from pvphong.shading.kernel.arithmetic import pasted
from pvphong.shading.kernel.pointers import call_light, call_reflectance, like, nowhere, shifted, taken
from pvphong.shading.kernel.rows import AT_WORK, BEGUN, BLOCK, GROUP, LEFT
from pvphong.shading.kernel.vectors import in_type


@pasted
def _load_normals(array: Any, start: int, count: int, s: Any, rows: Any, wide: Any) -> bool:
    """Normals into their rows; whether none is declined."""
    if s.turns_normals:
        loading.split(array, start, count, wide)
        loading.rotate_normals(s.normal_matrix, wide, rows)
    else:
        loading.split(array, start, count, shifted(rows, at.NX))
    if loading.measure_normals(rows):
        return True
    loading.split(array, start, count, wide)
    good = loading.scale_normals(wide, s.normal_matrix, s.turns_normals, rows)
    loading.measure_normals(rows)
    return good


@pasted
def _look(s: Any, rows: Any, points: Any) -> bool:
    """Directions to the viewer, and normals turned to it; whether no vertex is declined."""
    good = True
    if s.needs_eye:
        good = ways.approach(rows, points, s.eye[0], s.eye[1], s.eye[2])
        ways.look(rows)
    if s.is_flipped:
        ways.turn_normals(rows, not s.has_local_facing)
    if s.has_lobes_of_viewer:
        ways.face(rows)
    return good


@pasted
def _add_lambert(t: Any, varies: bool, gain: Any, rows: Any) -> None:
    """Add the light of one of which Lambert's factor alone is wanted."""
    red, green, blue = in_type(t.colors[0], rows)
    if t.is_even and varies:
        adding.add_parallel_weakened(rows, red, green, blue, *in_type(t.way, rows))
    elif t.is_even:
        adding.add_parallel(rows, red, green, blue, *in_type(t.way, rows))
    elif varies:
        adding.add_weakened(rows, gain, red, green, blue)
    else:
        adding.add_lambert(rows, red, green, blue)


@pasted
def _add_lobes(t: Any, s: Any, reflected: int, varies: bool, gain: Any, rows: Any) -> None:
    """Add the light of one whose lobes' factors stand in their rows; those that are 0 everywhere are left out."""
    if varies:
        for lobe in range(3):
            if reflected & (1 << lobe):
                adding.weaken(rows, at.FIRST + lobe * BLOCK, gain)
    if not s.has_albedo and reflected == 7:
        adding.add_three(rows, *in_type(t.colors[0], rows), *in_type(t.colors[1], rows), *in_type(t.colors[2], rows))
        return
    if not s.has_albedo and reflected & 3 == 3:
        adding.add_two(rows, *in_type(t.colors[0], rows), *in_type(t.colors[1], rows))
        reflected &= ~3
    for lobe in range(3):
        if reflected & (1 << lobe):
            target = at.HR if s.has_albedo and not s.takes_albedo & (1 << lobe) else at.R
            adding.add_lobe(rows, at.FIRST + lobe * BLOCK, target, *in_type(t.colors[lobe], rows))


@pasted
def _add_ambient(t: Any, s: Any, rows: Any) -> None:
    """Add what a light adds whatever the normal."""
    color, gain = in_type(t.ambient, rows), like(rows, t.gain)
    if s.sky < 0:
        if t.varies:
            adding.add_strength(rows, gain, *color)
        else:
            adding.add_evenly(rows, *color)
    elif t.varies:
        adding.add_strength_under_sky(rows, gain, *color)
    else:
        adding.add_sky(rows, *color)


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
        loading.take(shifted(channels, t.visible * s.channel_length), first, count, shifted(rows, at.VISIBLE))
        adding.block(rows, gain, varies)
        varies, gain = True, like(rows, 1.0)
    if not t.reflects:
        _add_lambert(t, varies, gain, rows)
        return good
    if t.is_even:
        adding.fill(rows, at.DX, *in_type(t.way, rows))
        ways.measure_ways(rows)
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
        loading.split(points, first, count, wide)
        if s.moves_points:
            loading.transform(s.matrix, s.w, wide)
    elif s.needs_points:
        loading.split(points, first, count, shifted(rows, at.PX))
    good = _look(s, rows, places) & good
    if s.tangents >= 0:
        for axis in range(3):
            channel = shifted(channels, (s.tangents + axis) * s.channel_length)
            loading.take(channel, first, count, shifted(rows, at.TX + axis * BLOCK))
        ways.straighten_tangents(rows)
    if s.sky >= 0:
        loading.take(shifted(channels, s.sky * s.channel_length), first, count, shifted(rows, at.SKY))
        adding.fill_under_sky(rows, *in_type(s.base, rows), *in_type(s.own, rows))
    else:
        adding.fill(rows, at.R, *in_type(s.base, rows))
    if s.has_albedo:
        adding.fill(rows, at.HR, *in_type(s.emission, rows))
    for turn in range(len(terms)):
        prefetch.ask(turn, first + BLOCK, points, normals, rgb, display, s)
        own = shifted(numbers, (turn + 1) * s.stride)
        good = _add_light(first, count, channels, terms[turn], s, numbers, own, rows, places) & good
    if s.has_albedo:
        loading.split(albedo, first, count, shifted(rows, at.ALBEDO_R))
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
        if s.is_sunlit and count == BLOCK and sunlight.shine_on(normals, first, s, terms[0], rgb):
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
        loading.unmark(rows)
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
    loading.unmark(rows)
    adding.fill(rows, at.VX, *in_type(s.to_eye, rows))
    adding.fill(rows, at.AX, *in_type(s.to_eye, rows))
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
