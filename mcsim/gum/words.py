"""What the comparison of sums and simulation says, in words made from its numbers."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator

import numpy as np

from mcsim.gum.course import Array, Course
from mcsim.systems.velocity.sources import SENSOR_TERMS

#: What sums and simulation may differ by before the words name it.
_SAME = 0.1
#: Less than this share of something is not worth a word; still less is rounding.
_NOTHING = 1e-3
_ROUNDING = 1e-9
#: Sources that are drawn once for all steps.
_COMMON = ("calibration matrix", "zero bias", "tilt change", "gravity")
_CALIBRATION = ("calibration matrix", "zero bias")


def comparison_words(course: Course) -> str:
    """A paragraph on where summing steps as independent misses, made from the numbers."""
    return "\n".join(textwrap.wrap(" ".join(_sentences(course)), 100)) + "\n"


def _sentences(course: Course) -> Iterator[str]:
    disturbed = max(course.total.max(), course.summed_total.max())
    if not disturbed > _ROUNDING * np.abs(course.truth).max():
        yield "Nothing disturbs this run: all uncertainties are zero."
        return
    yield _totals(course)
    yield from _sources(course)
    yield from _calibration(course)
    yield from _scatter(course)
    if course.sensor_terms:
        yield (
            "Eq. (30) and (31) leave out the accelerometer's own terms "
            f"({', '.join(course.sensor_terms)}); Monte Carlo has them, and alone they make "
            f"{course.simulated[SENSOR_TERMS][-1]:.2g} m/s."
        )
    variance = course.total[-1] ** 2
    if variance > 0.0:
        share = abs(course.interaction[-1]) / variance
        yield (
            "The sources acting together differ from the sum of each alone by "
            f"{share:.1%} of the variance."
        )


def _totals(course: Course) -> str:
    t, summed, simulated = course.time[-1], course.summed_total, course.total
    words = (
        f"After {t:.3g} s Eq. (30) gives u(v) = {summed[-1]:.3g} m/s and Monte Carlo "
        f"{simulated[-1]:.3g} m/s for one run ({_verdict(summed[-1], simulated[-1])})"
    )
    at = int(np.argmax(simulated))
    if simulated[at] > (1.0 + _SAME) * simulated[-1]:
        words += (
            f", at {course.time[at]:.3g} s, where Monte Carlo is largest, {summed[at]:.3g} and "
            f"{simulated[at]:.3g} m/s ({_verdict(summed[at], simulated[at])})"
        )
    if course.runs < 2:
        return f"{words}."
    mean, of_mean = course.summed_mean[-1], course.total_mean[-1]
    return (
        f"{words}; for the mean of {course.runs} runs after {t:.3g} s Eq. (31) gives {mean:.3g} "
        f"m/s and Monte Carlo {of_mean:.3g} m/s ({_verdict(mean, of_mean)})."
    )


def _sources(course: Course) -> Iterator[str]:
    largest = max(course.total.max(), course.summed_total.max())
    told, understated = [], []
    for source, summed in course.summed.items():
        alone = course.simulated[source]
        if max(summed.max(), alone.max()) < _NOTHING * largest:
            continue
        words = (
            f"{source} {_plain(summed[-1], largest)} by summing, {_plain(alone[-1], largest)} "
            f"simulated{_why(source, summed[-1], alone[-1], course)}"
        )
        at = int(np.argmax(alone))
        if alone[at] > (1.0 + _SAME) * alone[-1]:
            words += f", at most {alone[at]:.2g} m/s at {course.time[at]:.3g} s"
        told.append(words)
        if source in _COMMON and alone[-1] > (1.0 + _SAME) * summed[-1]:
            understated.append(source)
    yield f"Source by source, each acting alone, after {course.time[-1]:.3g} s: {'; '.join(told)}."
    if understated:
        yield (
            "An error that is the same in all steps adds up in proportion to their number, not to "
            f"its root: summing steps as independent understates {_listed(understated)}."
        )


def _calibration(course: Course) -> Iterator[str]:
    """What the errors of the calibration leave, where it is largest and at the end."""
    left: Array = np.hypot(*(course.simulated[name] for name in _CALIBRATION))
    at, alone = int(np.argmax(left)), course.by_acceleration
    scale = alone.max()
    if not max(scale, left[at]) > 0.0:
        return
    scale = max(scale, left[at])
    yield (
        "The errors of the calibration enter the corrected acceleration and the initial tilt. "
        f"Together they leave {_plain(left[at], scale)} at {course.time[at]:.3g} s, where that is "
        f"most, and {_plain(left[-1], scale)} after {course.time[-1]:.3g} s; through the "
        f"acceleration alone they would make {_plain(alone[at], scale)} and "
        f"{_plain(alone[-1], scale)} ({_balance(left, alone, at)})."
    )
    speed = np.abs(course.truth)
    ratio = float(left @ speed / (speed @ speed)) if speed.any() else 0.0
    if left[at] > 0.0 and np.max(np.abs(left - ratio * speed)) < _SAME * left[at]:
        yield f"What they leave goes with the velocity, {ratio:.2g} of it at every instant."


def _balance(left: Array, alone: Array, at: int) -> str:
    """Whether the tilt takes back what the acceleration brings, at an instant and at the end."""

    def cancels(i: int) -> bool:
        return bool(left[i] < _SAME * alone[i])

    if cancels(at) and cancels(-1):
        return f"the tilt takes back all but {_share(left[at], alone[at])} and " + (
            f"{_share(left[-1], alone[-1])}"
        )
    if cancels(-1):
        return "the tilt takes it back at the end only"
    if cancels(at):
        return "the tilt does not take it back at the end"
    return "the tilt does not take it back"


def _share(part: float, whole: float) -> str:
    share = part / whole
    return f"{share:.2g}" if share > _ROUNDING else "nothing"


def _scatter(course: Course) -> Iterator[str]:
    if course.measured:
        yield from _measured_scatter(course)
        return
    independent, stamps = (
        (course.other_scatter[-1], course.scatter[-1])
        if course.stamps
        else (course.scatter[-1], course.other_scatter[-1])
    )
    t = course.time[-1]
    if not course.summed["time base"].any():
        yield f"Runs of a group scatter by s(v) = {course.scatter[-1]:.2g} m/s after {t:.3g} s."
        return
    why = ", whose errors cancel from one interval to the next"
    yield (
        f"Runs of a group scatter after {t:.3g} s by s(v) = {independent:.2g} m/s where intervals "
        f"between samples err independently, and by {stamps:.2g} m/s where it is the time stamps "
        f"that err{why if stamps < (1.0 - _SAME) * independent else ''}."
    )


def _measured_scatter(course: Course) -> Iterator[str]:
    """Whether measured runs scatter by more than the noise of their sensor and time base."""
    if course.runs < 2:
        yield "A single run has no scatter; Eq. (31) needs repeated ones."
        return
    found, expected = course.scatter[-1], course.other_scatter[-1]
    words = (
        f"The {course.runs} runs scatter after {course.time[-1]:.3g} s by s(v) = {found:.2g} m/s; "
        f"noise and time base alone would make {expected:.2g} m/s"
    )
    # The standard deviation of normal values is uncertain by this part, three times over.
    beyond = 1.0 + 3.0 / np.sqrt(2.0 * (course.runs - 1))
    if found > beyond * expected:
        words += ": the runs themselves differ, or something else disturbs them"
    elif found * beyond < expected:
        words += ": they agree better than these say, which are overstated"
    yield f"{words}."


def _verdict(summed: float, simulated: float) -> str:
    if abs(summed - simulated) <= _SAME * simulated:
        return "within 10 %"
    if summed < simulated:
        times = f"{simulated / summed:.2g} times" if summed > 0.0 else "altogether"
        return f"summing understates it {times}"
    times = f"{summed / simulated:.2g} times" if simulated > _NOTHING * summed else "altogether"
    return f"summing overstates it {times}"


def _why(source: str, summed: float, alone: float, course: Course) -> str:
    """Why sum and simulation differ at the end, as far as the numbers tell."""
    if abs(summed - alone) <= _SAME * max(alone, summed):
        return ""
    if source == "noise":
        return (
            " (at rest it averages out over the samples)"
            if summed > alone
            else " (that of the rest is the same in every step)"
        )
    if source == "time base":
        return " (from one interval to the next it cancels)" if course.stamps else ""
    if summed > alone:
        return " (the same in every step, it takes itself back by then)"
    return " (it is the same in every step)"


def _plain(value: float, scale: float) -> str:
    """A velocity; what is rounding beside ``scale`` is nothing."""
    return f"{value:.2g} m/s" if value > _ROUNDING * scale else "nothing"


def _listed(names: list[str]) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} and {names[-1]}"
