"""Finds B2P2's masses and centres of mass from the readings of scales under its axles.

    python examples/python/weigh.py READINGS                prints them
    python examples/python/weigh.py READINGS --dump DUMP    and writes them into all nodes of DUMP

READINGS is a file such as examples/weighing.toml. DUMP is one of `cargo tool settings dump`: the
masses before are those of its guard, and without it the defaults. docs/weighing.md says how to
weigh, and what the program prints. It needs Python 3.11.

Least squares with the masses before as one more observation (a Gaussian prior), so that what the
readings do not show stays as it is.
"""
import argparse
import configparser
import re
import tomllib
from pathlib import Path

import numpy as np  # pip install numpy==2.4.6

DICTIONARY = Path(__file__).parents[2] / "docs/eds/guard.eds"
GUARD = 3  # product code
# Mass (mg) and place (um) of each body: of body 1 from axle 1 along its own axes, of body 2 from
# axle 2 and of body 3 from its rear end along the front part.
MASSES = ["body_1_mass", "body_1_forward", "body_1_left", "body_height",
          "body_2_mass", "body_2_forward", "body_2_left", "body_2_up",
          "body_3_mass", "body_3_forward", "body_3_left", "body_3_up"]
LENGTHS = ["l1", "k", "track_gauge"]  # um
AXLE_3 = 0.226  # from the rear end of body 3, m
JOINTS = [-60, -30, 0, 30, 60]  # chassis angles at which the centre of gravity is computed, degrees

MASS_BEFORE, PLACE_BEFORE = 0.5, 0.1  # deviations before: as a part of the mass, and m
CONTRADICTION = 4.0  # standard deviations by which a reading may be off
UNCERTAIN = 0.01  # standard deviation that the centre of gravity may have in the side view, m
NOT_MEASURED = 0.5  # part of the deviation before above which a value is not measured
STEPS, CONVERGED = 500, 1e-5  # of the iteration; the last step, kg and m
SMALL = 1e-4  # step of a numeric derivative, kg and m


class Refused(Exception):
    """Why no masses are written."""


def within(name, value, minimum, maximum):
    if not isinstance(value, (int, float)) or not minimum <= value <= maximum:
        raise Refused(f"{name} = {value}: allowed {minimum} to {maximum}")
    return value


def known(table, *names):
    for name in table:
        if name not in names:
            raise Refused(f"{name} is unknown; known are {', '.join(names)}")


def table_of(path):
    try:
        return tomllib.loads(Path(path).read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise Refused(str(error)) from error


class Weighing:
    """Readings of scales under two axles at one posture, kg."""

    def __init__(self, table):
        known(table, "joint_degrees", "pitch_degrees", *(f"axle_{axle}_kg" for axle in (1, 2, 3)))
        self.joint = within("joint_degrees", table.get("joint_degrees"), -120, 120)
        self.pitch = within("pitch_degrees", table.get("pitch_degrees"), -60, 60)
        self.axles = [axle for axle in (1, 2, 3) if f"axle_{axle}_kg" in table]
        if len(self.axles) != 2:
            raise Refused(f"{len(self.axles)} axles have readings; two must stand on scales and "
                          "the third in the air")
        readings = [np.atleast_1d(table[f"axle_{axle}_kg"]).tolist() for axle in self.axles]
        for reading in sum(readings, []):
            within("a reading in kg", reading, 0, 500)
        scales = len(readings[0])
        if scales not in (1, 2) or scales != len(readings[1]):
            raise Refused("both axles need one scale, or both two")
        self.names = [f"axle {axle}" for axle in self.axles]
        self.read = [sum(reading) for reading in readings]
        # In errors of one scale.
        self.errors = 2 * [np.sqrt(scales)]
        if scales == 2:
            self.names.append("left minus right")
            self.read.append(sum(left - right for left, right in readings))
            self.errors.append(2.0)


class Readings:
    """The file with the readings."""

    def __init__(self, path):
        table = table_of(path)
        bounds = {"scale_error_kg": (1e-4, 10), "pitch_error_degrees": (0, 10),
                  "joint_error_degrees": (0, 10)}
        known(table, *bounds, "weighing")
        self.scale_error, self.pitch_error, self.joint_error = (
            within(name, table.get(name), *bounds[name]) for name in bounds)
        self.weighings = [named(number, Weighing, weighing)
                          for number, weighing in enumerate(table.get("weighing", []), 1)]
        if not self.weighings:
            raise Refused("no [[weighing]]")
        self.names = [f"weighing {number}, {name}"
                      for number, weighing in enumerate(self.weighings, 1)
                      for name in weighing.names]
        self.read = np.concatenate([weighing.read for weighing in self.weighings])
        self.by_scales = self.scale_error * np.concatenate(
            [weighing.errors for weighing in self.weighings])
        self.show_left = any(len(weighing.read) == 3 for weighing in self.weighings)

    def fitted(self, robot, masses):
        """What the scales show for given masses, and the standard deviation of each reading."""
        def shown(pitch=0.0, joint=0.0):
            return np.concatenate(
                [named(number, robot.shown, masses, weighing, weighing.joint + joint,
                       weighing.pitch + pitch)
                 for number, weighing in enumerate(self.weighings, 1)], axis=-1)

        level = shown()
        turned = [shown(pitch=self.pitch_error) - level, shown(joint=self.joint_error) - level]
        # The balance from left to right does not depend on the angles.
        return level, np.hypot(self.by_scales, np.hypot(*turned))


def named(number, function, *arguments):
    """Calls the function; a refusal names the weighing."""
    try:
        return function(*arguments)
    except Refused as why:
        raise Refused(f"weighing {number}: {why}") from why


class Robot:
    """Computes what scales show, by the balance of moments. A place in the side view is the complex
    number `forward + 1j * up`, from axle 1, m. Masses may be an array of several robots."""

    def __init__(self, settings):
        self.l1, self.k, self.gauge = (settings[name] * 1e-6 for name in LENGTHS)
        if self.k < 1.001 * self.l1:
            raise Refused(f"k = {self.k} m: allowed {1.001 * self.l1} m or more")

    def pose(self, joint, pitch):
        """Axles, origins of the bodies and their directions, with a taut belt."""
        rear, front = np.exp(1j * np.radians([pitch, pitch + joint]))
        # Distance of axles 2 and 3: equation 2 of the paper.
        reach = (self.k**2 - self.l1**2) / (2 * (self.k + self.l1 * np.cos(np.radians(joint))))
        axles = np.array([0, self.l1 * rear, self.l1 * rear + reach * front])
        return axles, axles - [0, 0, AXLE_3 * front], np.array([rear, front, front])

    def moments(self, masses, joint, pitch):
        """Mass (kg), and its moments in the side view and to the left (kg m)."""
        _, origins, directions = self.pose(joint, pitch)
        mass, forward, left, up = np.moveaxis(masses.reshape(*masses.shape[:-1], 3, 4), -1, 0)
        places = origins + (forward + 1j * up) * directions
        return mass.sum(-1), (mass * places).sum(-1), (mass * left).sum(-1)

    def shown(self, masses, weighing, joint, pitch):
        """What the scales show, kg: under each axle, and how much more on the left. The tracks do
        not push along the ground."""
        axles, _, _ = self.pose(joint, pitch)
        first, second = weighing.axles
        near, far = axles[first - 1], axles[second - 1]
        base = (far - near).real
        if abs(base) < 0.02:
            raise Refused(f"axles {first} and {second} are {1e3 * abs(base):.0f} mm apart along "
                          "the ground: allowed 20 mm or more")
        third = axles[5 - first - second]
        line = near.imag + (far - near).imag * (third - near).real / base
        if third.imag < line:
            raise Refused(f"axle {6 - first - second} would be below the line through axles "
                          f"{first} and {second}, which carry the robot")
        mass, side, left = self.moments(masses, joint, pitch)
        front = (side.real - near.real * mass) / base
        shown = [mass - front, front, 2 * left / self.gauge]
        return np.stack(shown[:len(weighing.names)], axis=-1)

    def cog(self, masses):
        """Centre of gravity forward, left and up at each of the JOINTS, m."""
        def at(joint):
            mass, side, left = self.moments(masses, joint, 0.0)
            return np.stack([side.real, left, side.imag], axis=-1) / mass[..., None]

        return np.stack([at(joint) for joint in JOINTS], axis=-2)


def gradient(function, masses):
    """Derivative of each of the function's values by each mass and place."""
    steps = SMALL * np.eye(len(masses))
    return np.moveaxis(function(masses + steps) - function(masses - steps), 0, -1) / (2 * SMALL)


class Fit:
    """Masses (kg) and places (m) that explain the readings best, with their covariance."""

    def __init__(self, robot, readings, settings):
        self.readings, self.before = readings, np.array([settings[name] for name in MASSES]) * 1e-6
        is_mass = np.arange(len(MASSES)) % 4 == 0
        self.deviations_before = np.where(is_mass, MASS_BEFORE * self.before, PLACE_BEFORE)
        prior = self.deviations_before**-2.0
        self.masses = self.before
        for _ in range(STEPS):
            shown, deviations = readings.fitted(robot, self.masses)
            slopes = gradient(lambda masses: readings.fitted(robot, masses)[0], self.masses)
            weighted = slopes.T / deviations**2
            information = np.diag(prior) + weighted @ slopes
            pull = prior * (self.before - self.masses) + weighted @ (readings.read - shown)
            step = np.linalg.solve(information, pull)
            self.masses = self.masses + step
            if not np.isfinite(step).all() or abs(step).max() < 1e-3 * CONVERGED:
                break
        if not abs(step).max() <= CONVERGED:
            raise Refused("no masses give these readings; check units and signs")
        covariance = np.linalg.inv(information)
        self.fitted, self.reading_deviations = readings.fitted(robot, self.masses)
        variance = np.einsum("ri,ij,rj->r", slopes, covariance, slopes)
        # The masses follow a reading, so the difference varies less than the reading.
        self.off = (abs(readings.read - self.fitted)
                    / np.sqrt((self.reading_deviations**2 - variance).clip(1e-12)))
        self.deviations = np.sqrt(covariance.diagonal())
        self.cog, slopes = robot.cog(self.masses), gradient(robot.cog, self.masses)
        self.cog_deviations = np.sqrt(np.einsum("jai,ik,jak->ja", slopes, covariance, slopes))
        self.in_side_view = np.hypot(*self.cog_deviations.T[[0, 2]])

    def show(self):
        """Prints masses, readings and centre of gravity."""
        print("setting             before        now  deviation")
        for name, before, now, deviation, limit in zip(
                MASSES, 1e3 * self.before, 1e3 * self.masses, 1e3 * self.deviations,
                1e3 * NOT_MEASURED * self.deviations_before):
            note = "  not measured" if deviation > limit else ""
            unit = "g" if name.endswith("mass") else "mm"
            print(f"{name:<15} {before:>10.1f} {now:>10.1f} {deviation:>7.1f} {unit}{note}")
        print("\nreading, kg                             read   fitted  deviation")
        for name, *values in zip(self.readings.names, self.readings.read, self.fitted,
                                 self.reading_deviations):
            print(f"{name:<35}", *(f"{value:>8.3f}" for value in values))
        print("\ncentre of gravity, mm: from axle 1 forward, left, up; deviation in the side view")
        for joint, place, deviation in zip(JOINTS, 1e3 * self.cog, 1e3 * self.in_side_view):
            forward, left, up = place
            print(f"chassis angle {joint:>3} degrees: {forward:>7.1f} {left:>7.1f} {up:>7.1f}, "
                  f"{deviation:.1f}")

    def settings(self, bounds):
        """The settings of the masses. Refuses readings that contradict each other or show too
        little, and values that no setting has or that are far from those before."""
        worst = self.off.argmax()
        if not self.off[worst] <= CONTRADICTION:
            raise Refused(f"{self.readings.names[worst]}: {self.readings.read[worst]:.3f} kg was "
                          f"read, the masses give {self.fitted[worst]:.3f} kg; that is "
                          f"{self.off[worst]:.1f} standard deviations, allowed {CONTRADICTION}")
        for joint, deviation in zip(JOINTS, self.in_side_view):
            if not deviation <= UNCERTAIN:
                raise Refused(f"the centre of gravity at a chassis angle of {joint} degrees has a "
                              f"standard deviation of {1e3 * deviation:.1f} mm, allowed "
                              f"{1e3 * UNCERTAIN:.0f} mm: weigh at more chassis angles and pitches")
        for name, change, limit in zip(MASSES, self.masses - self.before, self.deviations_before):
            if not abs(change) <= limit:
                raise Refused(f"{name} changes by {1e6 * change:.0f}, allowed {1e6 * limit:.0f}: "
                              "check the signs of the angles; if it is right, set a value nearby "
                              "first")
        return {name: within(name, round(1e6 * value), *bounds[name])
                for name, value in zip(MASSES, self.masses)}

    def cog_uncertainty(self):
        """Prints the setting that the guard should have."""
        left = self.cog_deviations[:, 1] * self.readings.show_left
        largest = np.hypot(self.in_side_view, left).max()
        print(f"\ncog_uncertainty = {3e6 * largest:.0f} um covers three deviations")
        if not self.readings.show_left:
            print("not of the place to the left: that takes two scales under each axle")


def defaults():
    """Default and bounds of each setting, from the guard's object dictionary."""
    dictionary = configparser.ConfigParser(interpolation=None)
    dictionary.read(DICTIONARY, encoding="utf-8")
    objects = {section.get("ParameterName"): section for section in dictionary.values()}
    rows = {name: [int(objects[name][key]) for key in ("DefaultValue", "LowLimit", "HighLimit")]
            for name in MASSES + LENGTHS}
    return ({name: row[0] for name, row in rows.items()},
            {name: row[1:] for name, row in rows.items()})


def settings_in(dump, bounds):
    """Settings of the dump's guard."""
    guards = [node for node in table_of(dump).get("node", []) if node["identity"][1] == GUARD]
    if len(guards) != 1:
        raise Refused(f"{dump}: {len(guards)} nodes have the product code {GUARD} of a guard, not "
                      "one")
    return {name: within(name, value, *bounds[name])
            for name, value in guards[0]["settings"].items() if name in bounds}


def write(dump, results):
    """Writes the masses of all nodes. The old file stays as it is until the new one is complete."""
    head = "[node.settings]"
    lines = "".join(f"{name} = {value}\n" for name, value in results.items())
    old = re.sub(rf"^({'|'.join(results)}) *=.*\n", "", dump.read_text(), flags=re.MULTILINE)
    new = dump.with_suffix(".new")
    new.write_text(old.replace(f"{head}\n", f"{head}\n{lines}"))
    new.replace(dump)
    print(f"wrote the masses of {old.count(head)} nodes into {dump}")


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("readings", metavar="READINGS", help="file with the readings (TOML)")
    parser.add_argument("--dump", metavar="DUMP", type=Path,
                        help="has the masses before in its guard, and gets those of the readings")
    arguments = parser.parse_args()
    settings, bounds = defaults()
    if arguments.dump:
        settings |= settings_in(arguments.dump, bounds)
    fit = Fit(Robot(settings), Readings(arguments.readings), settings)
    fit.show()
    results = fit.settings(bounds)
    fit.cog_uncertainty()
    if arguments.dump:
        write(arguments.dump, results)


if __name__ == "__main__":
    try:
        main()
    except Refused as why:
        raise SystemExit(f"error: {why}; nothing was written")
