"""Errors in the words of the page, and buttons for their remedies.

The library's errors have the form "<name> must be <allowed>; got <value>. <remedy>", for people who write code. The
page shows them with its own labels, and offers a button wherever the remedy is an edit.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any, NamedTuple

from pvphong.studio.web.words import label_of

_REFUSAL = re.compile(
    r"(?P<name>[\w.\[\] -]{1,60}?) must be (?P<allowed>.+?); got (?P<got>.*?)\.(?: (?P<remedy>\S.*))?"
)

_RANGE = re.compile(r"a finite number(?: (?P<low_sign>>=?) (?P<low>\S+))?(?: and)?(?: <= (?P<high>\S+))?")

_THOUSANDS = "a number without thousands separators"

_WORDS = (
    ("True or False", "on or off"),
    ("LightModel(two_sided=True)", "the switch “two sided” in Scene"),
    ("LightModel(two_sided=False)", "a one-sided scene"),
    ("unique among the lights of the plotter", "different from the names of the other lights"),
    ("Change a light with set_light.", ""),
    ("3 finite numbers", "three numbers"),
    ("a finite number", "a number"),
)
"""Words of Python → words of the page."""


class Remedy(NamedTuple):
    """A button of a message.

    Parameters
    ----------
    label : str
        Text of the button.
    calls : list
        Triggers that the button calls one after the other, each as a list of name and arguments.
    """

    label: str
    calls: list[list[Any]]


def in_page_words(message: str) -> str:
    """Return an error message in the words of the page. Other messages are returned unchanged."""
    found = _REFUSAL.fullmatch(message)
    if found is None:
        return message
    name = re.sub(r"\[\d+\]$", "", found["name"])
    label = label_of(name)
    label, got, allowed = label[:1].upper() + label[1:], found["got"], found["allowed"]
    if got == "an empty input":
        return f"{label}: enter a value."
    if allowed == _THOUSANDS:
        return f"{label}: “{got}” is ambiguous, because the comma may separate thousands or decimals."
    if allowed == "a number":
        return f"{label}: “{got}” is not a number."
    if limits := _RANGE.fullmatch(allowed):
        return f"{label}: {_shortened(got)} is out of range. Enter {_range(limits)}."
    remedy = found["remedy"] or ""
    text = f"{label} must be {allowed}, not {_shortened(got)}. {remedy[:1].upper()}{remedy[1:]}".rstrip()
    for python, page in _WORDS:
        text = text.replace(python, page)
    return text.strip()


def _shortened(number: str) -> str:
    """Return a number's text without a fraction of zero: "2.0" becomes "2". Other texts are returned unchanged."""
    return re.sub(r"(?<=\d)\.0$", "", number)


def _range(limits: re.Match[str]) -> str:
    low, high = limits["low"], limits["high"]
    if low is None:
        return "a number" if high is None else f"a number up to {high}"
    if limits["low_sign"] == ">":
        return f"a number above {low}" + ("" if high is None else f", up to {high}")
    return f"{low} or more" if high is None else f"a number from {low} to {high}"


def remedies(message: str, trigger: str, args: Sequence[Any]) -> list[Remedy]:
    """Return the buttons for an error message.

    Parameters
    ----------
    message : str
        The error message, in the library's words.
    trigger : str
        Name of the trigger that raised it.
    args : sequence
        Arguments of this trigger.
    """
    found = _REFUSAL.fullmatch(message)
    if found is None:
        return []
    name, allowed = found["name"], found["allowed"]
    if name == "bounces" and "mix" in allowed:
        if trigger == "start_mix":
            return [Remedy("Set bounces to 0", [["edit", ["model.bounces", 0]], ["start_mix", [True]]])]
        return [Remedy("End the mix", [["start_mix", [False]], [trigger, [*args]]])]
    if name == "clim" and trigger == "set_colormap" and len(args) == 5 and allowed.endswith("first"):
        number, scalars, cmap, low, high = args
        return [Remedy("Swap them", [[trigger, [number, scalars, cmap, high, low]]])]
    if trigger not in ("edit", "type_number") or len(args) < 2:
        return []
    return [Remedy(f"Use {value}", [[trigger, [args[0], value, *args[2:]]]]) for value in _values(found)]


def _values(found: re.Match[str]) -> list[str]:
    """Return the values that the message suggests in place of the refused one. `found` is a match of the message."""
    got, allowed = found["got"], found["allowed"]
    if allowed == _THOUSANDS:
        both = {got.replace(",", ""): None}  # a dictionary keeps the order
        if got.count(",") == 1:
            both |= {f"{float(got.replace(',', '.')):g}": None} if "." not in got else {}
        return list(both)
    limits = _RANGE.fullmatch(allowed)
    if limits is not None:
        try:
            number = float(got)
        except ValueError:
            return []
        if limits["low"] is not None and limits["low_sign"] == ">=" and number < float(limits["low"]):
            return [limits["low"]]
        return [limits["high"]] if limits["high"] is not None and number > float(limits["high"]) else []
    _, did_you_mean, rest = (found["remedy"] or "").partition("Did you mean ")
    return re.findall(r"'([^']+)'", rest) if did_you_mean else []
