"""What makes a design good, and what it must fulfil."""

from __future__ import annotations

from stiffkit.design.measures import dimension_of
from stiffkit.design.spec import Constraint, Measure, Objective
from stiffkit.errors import FileError
from stiffkit.files import Entry, suggest
from stiffkit.robot import Robot
from stiffkit.study.sweep import STATISTICS
from stiffkit.study.sweep.written import read_statistic

WORDS = ("mass", "size")
"""Numbers of the whole robot."""

_OTHERS = ("of", "stroke", "joint", "workspace")


class MeasureReader:
    """Reads objectives and constraints of designs of a robot."""

    def __init__(self, robot: Robot, frequency_postures: int) -> None:
        """Take the robot, and at how many postures frequencies are known."""
        self.robot = robot
        self.frequency_postures = frequency_postures

    def objective(self, name: str, entry: Entry) -> Objective:
        """Return an objective. Raises FileError where there is no such measure."""
        maximise = "maximise" in entry
        given = entry["maximise" if maximise else "minimise"]
        if isinstance(given.node.value, dict):
            return Objective(self.measure(name, given), maximise)
        word = given.text()
        if word not in WORDS:
            raise given.error(
                f"'{word}' is no number of the whole robot",
                f"{suggest(word, WORDS)}; statistics are written as '{{min: QUANTITY}}'",
            )
        return Objective(Measure(name, "mass" if word == "mass" else "size"), maximise)

    def constraints(self, name: str, entry: Entry) -> list[Constraint]:
        """Return the constraint that a mapping says; two of a joint that is held at both ends."""
        if "joint" in entry:
            return self._of_joint(name, entry)
        for key in ("from", "to"):
            if key in entry:
                raise entry[key].error(
                    f"'{key}' belongs to a 'joint'", "write 'above' or 'below' for other bounds"
                )
        bounds = [key for key in ("above", "below") if key in entry]
        if "workspace" in entry:
            self._alone(entry, "workspace", "above")
            share = entry["above"].quantity(dimension_of(Measure(name, "reached"))) if bounds else 1
            return [Constraint(Measure(name, "reached"), above=True, bound=float(share))]
        if len(bounds) != 1:
            raise entry.error(
                f"{'both bounds stand' if bounds else 'no bound stands'} here, one is needed",
                "add 'above: VALUE' or 'below: VALUE', or make two constraints of it",
            )
        measure = self.measure(name, entry)
        given, above = entry[bounds[0]], bounds[0] == "above"
        if given.is_text("start"):
            return [Constraint(measure, above, None)]
        return [Constraint(measure, above, given.quantity(dimension_of(measure)))]

    def measure(self, name: str, entry: Entry) -> Measure:
        """Return what is measured. Raises FileError where nothing, or more than one thing, is."""
        statistics = [key for key in STATISTICS if key in entry]
        if "stroke" in entry:
            self._alone(entry, "stroke", "above", "below")
            return Measure(name, "stroke", joint=self._joint(entry["stroke"]))
        if "of" in entry and not statistics:
            word = entry["of"].text()
            if word not in WORDS:
                raise entry["of"].error(
                    f"'{word}' is no number of the whole robot",
                    f"{suggest(word, WORDS)}; or say which statistic of it",
                )
            self._alone(entry, "of", "above", "below")
            return Measure(name, "mass" if word == "mass" else "size")
        if not statistics:
            raise entry.error(
                "nothing that is measured stands here",
                f"give one of {', '.join((*STATISTICS, *_OTHERS))}",
            )
        column = read_statistic(name, entry, self.robot, self.frequency_postures)
        return Measure(name, "statistic", column)

    def _of_joint(self, name: str, entry: Entry) -> list[Constraint]:
        self._alone(entry, "joint", "from", "to")
        joint = self._joint(entry["joint"])
        lowest = Measure(f"{name}_lowest", "lowest", joint=joint)
        highest = Measure(f"{name}_highest", "highest", joint=joint)
        found = [
            Constraint(measure, above, entry[key].quantity(dimension_of(measure)))
            for key, measure, above in (("from", lowest, True), ("to", highest, False))
            if key in entry
        ]
        if not found:
            raise entry.error(
                "between what does the joint stay?", "add 'from: VALUE', 'to: VALUE', or both"
            )
        return found

    def _alone(self, entry: Entry, key: str, *others: str) -> None:
        """Raise FileError where other keys stand beside ``key`` than belong to it."""
        for other in entry.node.value if isinstance(entry.node.value, dict) else ():
            if other != key and other not in others:
                raise entry[other].error(
                    f"'{other}' cannot stand beside '{key}'", "make two constraints of it"
                )

    def _joint(self, entry: Entry) -> str:
        """Return a joint's coordinate, such as "slide_1.y"."""
        text = entry.text()
        joint, _, direction = text.partition(".")
        known = {name: j.motions for name, j in self.robot.joints.items() if j.motions}
        if joint not in known:
            raise entry.error(
                f"{self.robot.name} has no joint '{joint}' that moves", suggest(joint, known)
            )
        motions = known[joint]
        if not direction and len(motions) == 1:
            return f"{joint}.{motions[0]}"
        if direction not in motions:
            raise self._which(entry, joint, motions)
        return text

    @staticmethod
    def _which(entry: Entry, joint: str, motions: tuple[str, ...]) -> FileError:
        return entry.error(
            f"which coordinate of joint '{joint}'?",
            "write " + " or ".join(f"'{joint}.{motion}'" for motion in motions),
        )
