"""The one table of dataset variables: name, long name, units and flags."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from rotor_ida.model.parameters import OF_ROTOR
from rotor_ida.model.system_parameters import PARAMETERS_OF_SYSTEM
from rotor_ida.schema.flags import (
    DIRECTION,
    END,
    ENDING,
    ENDS_IN_WORDS,
    EVENT_KIND,
    EXACT,
    EXTREMUM,
    LINE_KIND,
    MODE,
    NO_YES,
    PASSAGE,
    RESPONSE,
    SPECIAL,
    STABILITY,
    STATUS,
    TRAPPING,
    VERDICT,
    WHIRL_DIRECTION,
    WHIRL_KIND,
)

# SI units by the scale of a machine, and those of systems that no scale of a machine has.
UNITS = {
    "length": "m", "time": "s", "velocity": "m s-1", "force": "N", "impulse": "N s",
    "energy": "J", "torque": "N m", "rate": "s-1", "speed": "s-1",
}  # fmt: skip
OTHER_UNITS = {
    "law_damping": "s m-1", "race_inertia": "kg m2", "race_drag": "N m s", "stator_mass": "kg",
    "stator_stiffness": "N m-1", "stator_damping": "N s m-1", "unbalance_moment": "kg m",
    "gravity": "m s-2", "applied_unbalance": "kg m", "unbalance": "kg m",
    "to": "s-1", "rate": "s-2",
    **dict.fromkeys(("contact_stiffness", "critical_stiffness", "support_stiffness"), "N m-1"),
    "table_stiffness": "N m-1", "table_damping": "N s m-1",
    "support_damping": "N s m-1", "drop_contact_damping": "s m-1", "cell_contact_damping": "s m-1",
}  # fmt: skip


@dataclass(frozen=True)
class Quantity:
    """Description of one variable of a dataset."""

    long_name: str
    units: str = "1"  # "1" if dimensionless; empty for text, and for values in units of their own
    scale: str = ""  # scale of a machine that converts it to SI units, empty if none
    flags: Mapping[str, int] = field(default_factory=dict)  # the number of each word of a category
    angular: bool = False  # whether it is an angular speed, whose unit s-1 is read as rad/s
    is_text: bool = False

    def attributes(self) -> dict[str, object]:
        """Return the attributes of a variable with this quantity."""
        attributes: dict[str, object] = {"long_name": self.long_name}
        if self.units:
            attributes["units"] = self.units
        if self.flags:
            attributes["flag_values"] = np.array(list(self.flags.values()), dtype=np.int8)
            attributes["flag_meanings"] = " ".join(self.flags)
        return attributes


# Quantities with the scales of a machine; `speed` is that of the spin.
length = partial(Quantity, scale="length")
time = partial(Quantity, scale="time")
velocity = partial(Quantity, scale="velocity")
speed = partial(Quantity, scale="speed", angular=True)
rate = partial(Quantity, scale="rate")
turning = partial(Quantity, scale="rate", angular=True)
force = partial(Quantity, scale="force")
impulse = partial(Quantity, scale="impulse")
energy = partial(Quantity, scale="energy")
text = partial(Quantity, units="", is_text=True)

# Parameters whose range of existence is computed for attractors, where they are not 0.
WITH_EXTENTS = ("omega", "zeta", "delta0", "shaft_stiffness", "contact_damping", "friction")


def _states(words: str, axes: Mapping[str, str], where: Mapping[str, str]) -> dict[str, Quantity]:
    """Return the components of states, by prefix and by the words after the component."""
    nouns = {"": "displacement", "v": "velocity"}
    return {
        f"{prefix}{kind}{axis}": Quantity(
            words.format(noun=noun, axis=side) + behind, scale="velocity" if kind else "length"
        )
        for prefix, behind in where.items()
        for kind, noun in nouns.items()
        for axis, side in axes.items()
    }


QUANTITIES: dict[str, Quantity] = {
    # a fit
    "unknown": text("fitted parameter"),
    "unknown_too": text("fitted parameter, second axis"),
    "estimate": Quantity("estimate, in the unit of the parameter", ""),
    "standard_error": Quantity("standard error, in the unit of the parameter", ""),
    "lower": Quantity("lower end of the confidence interval, in the unit of the parameter", ""),
    "upper": Quantity("upper end of the confidence interval, in the unit of the parameter", ""),
    "first_guess": Quantity("first guess, in the unit of the parameter", ""),
    "told": Quantity(
        "whether the search converged and the standard error is at most half of the value",
        flags=NO_YES,
    ),
    "unit": text("unit of the value"),
    "covariance": Quantity("covariance of two values, in their units", ""),
    "record": Quantity("number of the record of signals"),
    "fitted_forward_whirl_amplitude": length("fitted amplitude of forward whirl"),
    "fitted_backward_whirl_amplitude": length("fitted amplitude of backward whirl"),
    "fitted_forward_phase_lag": Quantity("fitted phase lag of forward whirl", "radian"),
    "fitted_backward_phase_lag": Quantity("fitted phase lag of backward whirl", "radian"),
    **{
        f"{sense}_residual_{part}": Quantity(
            f"residual of the {sense} whirl over its standard error, without the errors that "
            f"residuals share, {words}"
        )
        for sense in ("forward", "backward")
        for part, words in (("real", "along the mark"), ("imag", "across it"))
    },
    "measured_time": time("measured time of contact entry or exit"),
    "fitted_time": time("fitted time of contact entry or exit"),
    "time_error": time("standard error of a measured contact time"),
    "compared": Quantity("1 where a measured contact time is compared, else 0"),
    "touch_record": Quantity("number of the record with the contact"),
    "chi_square": Quantity("sum of squared residuals over their variances"),
    "degrees_of_freedom": Quantity("number of data less number of fitted parameters"),
    "noise": length("standard deviation of the noise in each direction"),
    # parameters
    **{name: Quantity(each.meaning) for name, each in OF_ROTOR.items()},
    **_states(
        "{axis} {noun}",
        {"x": "horizontal", "y": "vertical"},
        {"": "", "event_": " at the event", "start_": " at the start", "end_": " at the end"},
    ),
    # on axes that rotate with the unbalance
    **_states(
        "{noun} {axis} the unbalance",
        {"x": "along", "y": "across"},
        {"rotating_": "", "event_rotating_": " at the event", "special_": ""},
    ),
    # a run
    "t": time("time"),
    "starts_in_contact": Quantity("whether the run starts in contact", flags=NO_YES),
    "event_time": time("time of contact entry or exit"),
    "event_kind": Quantity("kind of contact event", flags=EVENT_KIND),
    # a rotor system
    "node": text("node of a rotor system"),
    "axial_position": length("position of a node along the axis"),
    "contact_node": text("node of a contact"),
    "clearance": length("radial clearance of a contact"),
    "contact_clearance": length("radial clearance of a contact"),
    **{
        name: Quantity(each.meaning)
        for name, each in PARAMETERS_OF_SYSTEM.items()
        if name in {"damping", "stiffness", "unbalance"}
    },
    "contact_stator": text("stator of a contact, empty for the ground"),
    **{
        f"{of}_{axis}": length(f"{word} {noun}")
        for axis, word in (("x", "horizontal"), ("y", "vertical"))
        for of, noun in (
            ("centre", "offset of the centre of a stator from the place of rest"),
            ("contact", "displacement at a contact from the centre of its stator"),
            ("event_contact", "displacement at the contact of an event from the centre"),
        )
    },
    "event_contact": Quantity("number of the contact of an event"),
    "node_amplitude": length("amplitude of a node at the spin speed"),
    "node_major_axis": length("largest axis of the orbit of a node, from peak to peak"),
    "node_minor_axis": length(
        "smallest axis of the orbit of a node, from peak to peak, negative if it is backward"
    ),
    **{
        f"node_{sense}_{name}": Quantity(words.format(sense), unit, scale)
        for sense in ("forward", "backward")
        for name, words, unit, scale in (
            ("amplitude", "amplitude of the {} circle of the orbit of a node", "1", "length"),
            ("phase_lag", "phase by which the {} circle of the orbit lags", "radian", ""),
        )
    },
    "unbalance_radius": length(
        "largest distance from the centre of the stator by unbalance and load, without contact"
    ),
    "peak_speed": speed("speed of the peak of the response near the critical speed"),
    "peak_node": text("node with the largest peak near the critical speed"),
    "peak_major_axis": length("largest axis of the orbit at the peak, from peak to peak"),
    "contact_stiffness": Quantity("stiffness of springs at the contacts"),
    "eigenvalue": Quantity("number of the eigenvalue, in order of whirl speed"),
    "damping_ratio": Quantity("damping ratio of the motion, negative if it grows"),
    "branch_amplitude": length("amplitude of a whirl at a contact"),
    "branch_stability": Quantity("stability of a whirl", flags=STABILITY),
    # a report on close clearances
    "case": Quantity("number of the case of unbalance"),
    "probe": text("node at which vibration is measured"),
    "major_axis": length("largest axis of the orbit at a contact, from peak to peak"),
    "probe_major_axis": length("largest axis of the orbit at a probe, from peak to peak"),
    "scale_factor": Quantity("vibration limit over the largest axis at a probe, at most 6"),
    "vibration_limit": length("vibration limit, from peak to peak"),
    "running_share": Quantity(
        "scaled largest axis over the diametral clearance, at continuous speeds"
    ),
    "sag_share": Quantity(
        "largest static deflection from the centre over the radial clearance, at continuous speeds"
    ),
    "running_share_speed": speed("continuous speed of the largest such share"),
    "passage_share": Quantity(
        "scaled largest axis over the diametral clearance, from rest to the trip speed"
    ),
    "clearance_verdict": Quantity(
        "whether the scaled orbit passes, fills too much of the clearance, or touches",
        flags=VERDICT,
    ),
    "applied_unbalance": Quantity("unbalance at a node in a case"),
    "applied_phase": Quantity("angle of the unbalance at a node in a case", "radian"),
    "critical_speed": speed("critical speed"),
    "critical_stiffness": Quantity("stiffness of springs at the contacts at the critical speed"),
    "critical_damping_ratio": Quantity("damping ratio of the motion at the critical speed"),
    "critical_sense": Quantity(
        "direction of the whirl at the critical speed", flags=WHIRL_DIRECTION
    ),
    "amplification_factor": Quantity("speed of a peak over its width at 0.707 of its height"),
    "separation_margin": Quantity(
        "distance of a critical speed from the continuous speeds over the nearer of their ends"
    ),
    "required_margin": Quantity("separation margin that the amplification factor requires"),
    **{
        f"{prefix}_{name}": Quantity(f"{words} a synchronous rub {where}", scale=scale, flags=flags)
        for prefix, where in (
            ("rub", "at continuous speeds"),
            ("passage_rub", "from rest to the trip speed"),
        )
        for name, words, scale, flags in (
            ("force", "largest force of", "force", {}),
            ("speed", "speed of", "speed", {}),
            ("stability", "stability of", "", STABILITY),
        )
    },
    "whip_speed": turning("whirl speed of dry whip, negative"),
    "whip_amplitude": length("amplitude of dry whip at the contact"),
    "whip_force": force("normal force of dry whip"),
    "whip_stability": Quantity("stability of dry whip", flags=STABILITY),
    "node_phase_lag": Quantity(
        "phase by which the motion of a node at the spin speed lags", "radian"
    ),
    "event_state": Quantity("displacement and velocity of all coordinates at an event"),
    "final_state": Quantity(
        "displacement and velocity of all coordinates, and speeds of races, at the end"
    ),
    "event_race_speed": speed("speed of the race of a contact at an event"),
    "episode_contact": Quantity("number of the contact that an episode is of"),
    **{
        f"{name}_matrix": Quantity(f"{words} matrix of the rotor, in the units of its coordinates")
        for name, words in {
            "mass": "mass",
            "damping": "damping",
            "gyroscopic": "gyroscopic",
            "stiffness": "stiffness",
            "stiffness_rate": "stiffness, by the rate of the speed,",
        }.items()
    },
    "node_rows": Quantity("displacement of a node by a unit of a coordinate"),
    "constant_force": Quantity("constant force on each coordinate of rotor and stators"),
    "gravity": Quantity("acceleration of gravity whose weight is a part of the constant force"),
    "initial_state": Quantity(
        "displacement and velocity of all coordinates, and speeds of races, at the start"
    ),
    "start_state": Quantity("displacement and velocity of all coordinates at time 0"),
    "stator_number": Quantity("number of the moving stator of a contact, -1 if it has none"),
    "law_stiffness": Quantity("contact stiffness: force over indentation to the exponent"),
    "law_exponent": Quantity("exponent of the contact force"),
    "law_damping": Quantity("contact damping: relative increase of force per approach speed"),
    "law_friction": Quantity("friction coefficient of the contact"),
    "law_radius": length("radius of the surface of the rotor in a contact"),
    "race_is_of_stator": Quantity("whether the race is that of the stator, which contacts share"),
    "race_radius": length("radius of the surface of a race"),
    "race_inertia": Quantity("moment of inertia of a race"),
    "race_drag": Quantity("drag torque of a race over its speed"),
    "race_speed": speed("speed of a race at time 0"),
    "race_speed_max": speed("maximum of the speed of a race"),
    "race_speed_max_time": time("time of the maximum of the speed of a race"),
    "race_speed_min": speed("minimum of the speed of a race"),
    "race_speed_min_time": time("time of the minimum of the speed of a race"),
    "stator_mass": Quantity("mass of a moving stator"),
    "stator_stiffness": Quantity("stiffness of the mount of a moving stator"),
    "stator_damping": Quantity("damping of the mount of a moving stator"),
    "bearing_node": text("node of a bearing whose coefficients depend on the speed"),
    "bearing_stator": text("node that holds the bearing, empty for the ground"),
    "bearing_name": text("name of the bearing, empty without one"),
    "table_bearing": Quantity("number of the bearing of a row of the tables"),
    "table_speed": speed("spin speed of a row of the tables of the bearings"),
    "table_stiffness": Quantity("stiffness of a bearing at the speed of the row"),
    "table_damping": Quantity("damping of a bearing at the speed of the row"),
    "unbalance_node": text("node of an unbalance"),
    "unbalance_moment": Quantity("unbalance: mass times eccentricity"),
    "unbalance_phase": Quantity("angle of an unbalance from the x axis at time 0", "radian"),
    # a drop
    "largest_force_time": time("time of the largest contact force"),
    "largest_impulse": impulse("largest impulse of one complete contact"),
    "total_contact_time": time("time in contact"),
    "longest_contact_time": time("duration of the longest contact"),
    "mean_contact_force": force("mean normal force while in contact"),
    "load_capacity": force("load capacity of a bearing, as given"),
    "load_ratio": Quantity("largest contact force over the load capacity"),
    "first_roll_time": time("time at which the surfaces first roll"),
    "largest_race_speed": speed("largest speed of the race of a contact"),
    "race_speed_time": time("time of the largest speed of the race"),
    "whirl_turns": Quantity("turns of the longest whirl in a bearing, negative if backward"),
    "rest_time": time("time from which the contact lasts to the end"),
    "standstill_time": time("time from which the speed stays below 1 % of that at the start"),
    "standstill_time_error": time("estimated error of the time of standstill"),
    "node_clearance": length("close clearance at a node"),
    "node_excursion": Quantity("largest distance from the axis over the clearance at a node"),
    # many drops
    "drop": Quantity("number of the drop"),
    "first_touch_time": time("time of the first touch"),
    "drop_phase": Quantity("angle of the rotor at the drop", "radian"),
    "drop_friction": Quantity("friction coefficient of all bearings in a drop"),
    "drop_contact_damping": Quantity("contact damping of all bearings in a drop"),
    "drop_unbalance_factor": Quantity("factor of all unbalance in a drop"),
    "drop_clearance_factor": Quantity("factor of all clearances in a drop"),
    "quantile": Quantity("fraction of drops below"),
    **{
        f"{name}_fraction{end}": Quantity(f"{words}fraction of drops {which}")
        for name, which in (
            ("backward_whirl", "with a backward whirl in the bearing"),
            ("rest", "at rest in the bearing at the end"),
            ("decided", "whose largest force comes before the horizon"),
            ("overload", "whose largest force is above the load capacity"),
        )
        for end, words in (
            ("", ""),
            ("_low", "lower end of the "),
            ("_high", "upper end of the "),
            ("_change", "change on coarser grids of the "),
        )
    },
    "cell_friction": Quantity("friction coefficient of all bearings in a cell of the grid"),
    "cell_contact_damping": Quantity("contact damping of all bearings in a cell of the grid"),
    "cell_unbalance_factor": Quantity("factor of all unbalance in a cell of the grid"),
    "cell_clearance_factor": Quantity("factor of all clearances in a cell of the grid"),
    "cell_largest_force": force("largest contact force over the phases of a cell"),
    "cell_excursion": Quantity("largest radius over the clearance over the phases of a cell"),
    "cell_backward_whirl_fraction": Quantity(
        "fraction of the phases of a cell with a backward whirl in the bearing"
    ),
    "support_node": text("node of a support"),
    "support_fails": Quantity("whether a support fails", flags=NO_YES),
    "support_stiffness": Quantity("stiffness of a support, by axis"),
    "support_damping": Quantity("damping of a support, by axis"),
    "support_load": force("static force of a support on the rotor"),
    "event_time_error": time("estimated error of the event time"),
    "event_time_shift": time("how far the event moves with more modes"),
    "horizon": time("time up to which the start determines the orbit"),
    "entry_time": time("time at which the contact begins"),
    "exit_time": time("time at which the contact ends"),
    "peak_force_time": time("time of the largest force in the contact"),
    "peak_time": time("time of largest indentation in the contact"),
    "peak_indentation": length("largest indentation in the contact"),
    "peak_force": force("largest contact force in the contact"),
    "contact_duration": time("time from entry to exit"),
    "impulse": impulse("impulse of the contact force during the run"),
    "entry_speed": velocity("speed at entry"),
    "entry_angle": Quantity("angle from the stator's normal to the velocity at entry", "radian"),
    "energy_lost": energy("kinetic energy at entry less that at exit"),
    "contact_loss": energy("energy lost in the contact by its damping"),
    "heat": energy("heat of slipping in the contact"),
    "slip_distance": length("slip distance of the surfaces in the contact"),
    "rolling_time": time("rolling time of the disc in the contact"),
    "mode": Quantity("mode of motion: flight, slipping, rolling or loose", flags=MODE),
    "slip_speed": velocity("speed of the disc's rim relative to the stator, positive forwards"),
    "normal_force": force("normal force of the contact"),
    "speed": speed("instantaneous spin speed over the reference frequency"),
    "angle": Quantity("angle of the unbalance", "radian"),
    "event_speed": speed("spin speed at the event"),
    "revolutions": Quantity("number of revolutions in the run"),
    "event_angle": Quantity("angle of the unbalance at the event", "radian"),
    "whirl_direction": Quantity(
        "whirl direction about the bearing axis at the peak, none for a straight bounce",
        flags=WHIRL_DIRECTION,
    ),
    # a summary of contacts
    "contact_count": Quantity("number of contacts"),
    "contacts_per_revolution": Quantity("number of contacts per revolution"),
    "contact_fraction": Quantity("fraction of the time in contact"),
    "largest_force": force("largest contact force"),
    "mean_peak_force": force("mean of the largest forces of the contacts"),
    "total_impulse": impulse("impulse of all contacts"),
    "impulse_per_revolution": impulse("impulse of contacts per revolution"),
    "energy_lost_per_revolution": energy("kinetic energy lost in complete contacts per revolution"),
    "total_heat": energy("heat of slipping in contacts"),
    "heat_per_revolution": energy("heat of slipping in contacts per revolution"),
    "total_slip_distance": length("slip distance of the surfaces"),
    "slip_distance_per_revolution": length("slip distance of the surfaces per revolution"),
    "rolling_fraction": Quantity("fraction of the contact time in which the disc rolls"),
    "total_contact_loss": energy("energy lost in contacts by their damping"),
    "forward_fraction": Quantity("fraction of the contacts in forward whirl"),
    # sections, spectra and forces
    "crossing": Quantity("number of the point of the section"),
    "crossing_time": time("time at which the motion crosses the section"),
    "crossing_state": Quantity("displacement and velocity of all coordinates at the crossing"),
    "frequency": turning("circular frequency, positive for forward whirl"),
    "frequency_over_omega": Quantity("frequency over spin speed, positive for forward whirl"),
    "whirl_amplitude": length("amplitude of the whirl at the frequency"),
    "force": force("contact force"),
    "force_x": force("horizontal contact force on the rotor"),
    "force_y": force("vertical contact force on the rotor"),
    "tangential_force": force("tangential contact force on the rotor, positive backward"),
    "peak_fraction": Quantity("fraction of the contacts with no larger peak force"),
    # signals of probes and a keyphasor
    "keyphasor": time("time of a pulse of the keyphasor"),
    "window": Quantity("number of the window"),
    "order": Quantity("frequency as a multiple of the spin speed"),
    "forward_whirl_amplitude": length("amplitude of the forward whirl"),
    "backward_whirl_amplitude": length("amplitude of the backward whirl"),
    "forward_phase_lag": Quantity("phase by which the forward whirl lags the mark", "radian"),
    "backward_phase_lag": Quantity("phase by which the backward whirl lags the mark", "radian"),
    "forward_amplitude_error": length("standard error of the amplitude of the forward whirl"),
    "backward_amplitude_error": length("standard error of the amplitude of the backward whirl"),
    "probe_angle": Quantity("angle of the probe from the x axis", "degree"),
    "probe_peak_to_peak": length("reading of the probe, of one order, peak to peak"),
    "probe_phase_lag": Quantity("phase by which the reading of the probe lags the mark", "radian"),
    "probe_error": length("standard error of the peak to peak of one order"),
    "direct_peak_to_peak": length("whole reading of the probe in the window, peak to peak"),
    "half_power_low": speed("speed below the peak at 0.707 of its height"),
    "half_power_high": speed("speed above the peak at 0.707 of its height"),
    "bode_amplitude": length("amplitude at the peak, of a probe peak to peak"),
    "filter_error": length("standard error of a displacement filtered to one order"),
    "whirl_phase": Quantity("phase of the whirl at the time 0", "radian"),
    "mean_x": length("mean horizontal position that was subtracted"),
    "mean_y": length("mean vertical position that was subtracted"),
    "offset_x": length("mean horizontal displacement"),
    "offset_y": length("mean vertical displacement"),
    "window_residual": length("root mean square of the residual after the orders"),
    "whirl_over_spin": Quantity("whirl speed over spin speed, negative for backward whirl"),
    "whirl_sense": Quantity("direction of the whirl", flags=WHIRL_DIRECTION),
    "bandwidth": turning("equivalent noise bandwidth, as a circular frequency"),
    "noise_floor": length("amplitude of noise in one line of the spectrum"),
    "twice_amplitude": length("amplitude at twice the speed, forward and backward together"),
    "line_order": Quantity("order of the strongest line beside 1X, negative for backward whirl"),
    "line_amplitude": length("amplitude of the strongest line beside 1X"),
    "line_opposite_amplitude": length("amplitude at its order in the other direction"),
    "least_crest": Quantity("smallest crest of x and y, up and down, over that of a sine"),
    "floor_ratio": Quantity("floor between 0.1X and 0.9X over the highest line"),
    # Lyapunov exponents
    "exponent": Quantity("number of the Lyapunov exponent, the largest first"),
    "lyapunov_exponent": rate("Lyapunov exponent"),
    "lyapunov_error": rate("standard error of the Lyapunov exponent"),
    "running_exponent": rate("mean rate of stretching up to the time"),
    "exponent_sum": rate("sum of the four Lyapunov exponents"),
    "divergence": rate("divergence of the flow, minus four times the damping ratio"),
    # extrema of the radius
    "extremum_count": Quantity("number of extrema of the distance from the bearing axis"),
    "extremum_row": Quantity("row of the first extremum"),
    "extremum_radius": length("distance from the bearing axis at its extremum"),
    "extremum_kind": Quantity("kind of the extremum", flags=EXTREMUM),
    "extremum_speed": speed("spin speed at the extremum"),
    # closed forms
    "branch": Quantity("number of the synchronous whirl, in order of amplitude"),
    "fold": Quantity("number of the fold, in order of speed"),
    "amplitude": length("amplitude of the motion at the spin speed"),
    "phase_lag": Quantity(
        "phase by which the motion at the spin speed lags the unbalance", "radian"
    ),
    "stability": Quantity("stability of the synchronous whirl", flags=STABILITY),
    "in_contact": Quantity("whether the synchronous whirl touches the stator", flags=NO_YES),
    "point": Quantity("number of the point along the curve"),
    "piece": Quantity("number of the connected piece of the curve, -1 after its last point"),
    "torque": Quantity("torque that maintains the speed on the synchronous whirl", scale="torque"),
    "driven_stability": Quantity(
        "stability of the synchronous whirl where a drive maintains the speed", flags=STABILITY
    ),
    "growth_rate": rate("largest real part of the whirl's eigenvalues"),
    "fold_omega": Quantity("spin speed of the fold over the reference frequency"),
    "fold_amplitude": length("amplitude of the synchronous whirl at the fold"),
    "fold_drift": Quantity("coefficient of the excess speed in the amplitude's growth at the fold"),
    "fold_curvature": Quantity(
        "coefficient of the squared excess amplitude in its growth at the fold"
    ),
    "fold_remainder": Quantity(
        "deviation of a late jump from the law, over the rate and the logarithm of its inverse"
    ),
    "fold_passage": Quantity(
        "direction in which the speed passes the fold from a stable whirl", flags=PASSAGE
    ),
    "rate": Quantity("magnitude of the rate of change of the spin speed"),
    "jump_omega": Quantity(
        "spin speed at which the rotor has jumped from the fold, over the reference frequency"
    ),
    "hopf": Quantity("number of the Hopf point, in order of speed"),
    "hopf_omega": Quantity("spin speed of the Hopf point over the reference frequency"),
    "hopf_amplitude": length("amplitude of the synchronous whirl at the Hopf point"),
    "grazed_contact": Quantity("number of the contact that a whirl just touches"),
    "hopf_frequency": turning("circular frequency, on rotating axes, of the cycle born there"),
    "whirl": Quantity("number of the backward whirl"),
    "backward_amplitude": length("radius of the backward whirl"),
    "whirl_speed": turning("angular speed of the whirl, negative if backward"),
    "backward_kind": Quantity("motion of the disc on the stator", flags=WHIRL_KIND),
    "backward_stability": Quantity("stability of the backward whirl", flags=STABILITY),
    "backward_normal_force": force("normal force of the contact"),
    "backward_tangential_force": force("tangential force of the contact"),
    "birth_omega": Quantity("lowest spin speed of dry whip over the reference frequency"),
    "landing_amplitude": length("amplitude of the other whirl at a fold"),
    "cusp_zeta": Quantity("damping ratio at the cusp, above which the response curve has no fold"),
    "cusp_omega": Quantity(
        "spin speed at the cusp, where the last folds merge, over the reference frequency"
    ),
    "cusp_amplitude": length("amplitude at the cusp, where the last folds merge"),
    "peak_amplitude": length("largest amplitude of a contacting whirl"),
    "peak_omega": Quantity(
        "spin speed at which the amplitude is largest, over the reference frequency"
    ),
    "peak_contact_force": force("contact force where the amplitude is largest"),
    "indentation": length("indentation of the contact"),
    "rest_stability": Quantity("stability of the rest position", flags=STABILITY),
    "radial_frequency": turning("undamped circular frequency along the radius"),
    "tangential_frequency": turning("undamped circular frequency across the radius"),
    "rest_growth_rate": rate("largest real part of the eigenvalues at rest"),
    "restitution": Quantity("coefficient of restitution: speed at exit over that at entry"),
    "restoring_x": force("horizontal restoring force"),
    "restoring_y": force("vertical restoring force"),
    "potential": energy("energy stored in the contact"),
    "energy": energy("kinetic energy and energy stored in the contact"),
    "circular_period": time("period of a free whirl on a circle"),
    "planar_period": time("period of free vibration on a line"),
    "period": time("period of the motion"),
    "solution_x": length("horizontal displacement of a claimed solution"),
    "solution_y": length("vertical displacement of a claimed solution"),
    # sweeps
    "start": Quantity("number of the start"),
    "direction": Quantity("direction in which the speed is swept", flags=DIRECTION),
    "response": Quantity("kind of response over the final window", flags=RESPONSE),
    "radius_min": length("smallest distance from the bearing axis over the final window"),
    "radius_max": length("largest distance from the bearing axis over the final window"),
    "window_start": time("time at which the final window begins"),
    "window_end": time("time at which the final window and the run end"),
    "status": Quantity("whether the run was completed", flags=STATUS),
    "cycle_distance": Quantity(
        "estimated distance from the settled motion at the end, relative to its size"
    ),
    "touched": Quantity("whether the contact is touched in the final window", flags=NO_YES),
    "node_radius_min": length("smallest distance of a node from the axis over the final window"),
    "node_radius_max": length("largest distance of a node from the axis over the final window"),
    "message": text("why the run failed or its response is unresolved"),
    "event_count": Quantity("number of contact events of the run"),
    "event_row": Quantity("row of the first contact event of the run"),
    # many run-ups
    "to": Quantity("spin speed at the end of the ramp over the reference frequency"),
    "phase": Quantity("angle of the unbalance at time 0", "radian"),
    "ending": Quantity("how the run-up ends, after a time at the last speed", flags=ENDING),
    "largest_radius": length("largest distance from the bearing axis on the ramp"),
    "node_largest_radius": length("largest distance of the node from the axis on the ramp"),
    "smallest_gap": length("clearance less the largest distance from the bearing axis"),
    "largest_radius_speed": speed("spin speed where the distance is largest"),
    "largest_force_speed": speed("spin speed where the force is largest"),
    "first_touch_speed": speed("spin speed at the first touch"),
    "last_exit_speed": speed("spin speed at the last exit"),
    "first_roll_speed": speed("spin speed where the disc first rolls"),
    "contact_time": time("time in contact on the ramp"),
    "end_angle": Quantity("angle of the unbalance at the end of the ramp", "radian"),
    "failed_count": Quantity("number of run-ups that failed"),
    **{
        f"{word}_fraction": Quantity(f"fraction of run-ups that end {how}")
        for word, how in ENDS_IN_WORDS.items()
    },
    **{
        f"{word}_fraction_error": Quantity(f"standard error of the fraction that ends {how}")
        for word, how in ENDS_IN_WORDS.items()
    },
    # basins
    "attractor": Quantity("number of the attractor"),
    "label": Quantity("number of the attractor on which the start ends"),
    "settling_time": time("time at which the orbit was decided, or the simulation ended"),
    "kind": Quantity("kind of response on the attractor", flags=RESPONSE),
    "trapping": Quantity("evidence for the trapping region of the attractor", flags=TRAPPING),
    "lifetime": time("mean time after which the motion ends, infinite where that was not seen"),
    "lifetime_low": time("lower 95 % confidence bound of the lifetime"),
    "confirmed": Quantity(
        "whether a separate run leads from a start to the attractor", flags=NO_YES
    ),
    "count": Quantity("number of starts that end on the attractor"),
    "fraction": Quantity("fraction of computed starts that end on the attractor"),
    "fraction_error": Quantity(
        "standard error of the fraction, for starts drawn at random from their range"
    ),
    "settling_median": time("median of the times at which starts on the attractor were decided"),
    "settling_95": time("time by which 95 % of them were decided"),
    "mean_force": force("mean contact force: the impulse in a unit of time"),
    "dissipation_per_revolution": energy("energy dissipated by damping per revolution"),
    "contact_loss_per_revolution": energy("energy dissipated by contact damping per revolution"),
    "excursion": Quantity("largest distance from the bearing axis over the clearance"),
    "missed_fraction": Quantity(
        "largest basin fraction of an attractor that is missed with a probability of 5 %"
    ),
    "basin_entropy": Quantity("mean entropy of the attractors of starts in small boxes"),
    "boundary_entropy": Quantity("mean entropy over the boxes with more than one attractor"),
    # distances from the basin boundary
    "target": Quantity("number of the attractor reached after the shock"),
    "velocity_shock": velocity("smallest velocity shock found that leads to the target"),
    "displacement_shock": length("smallest displacement shock found that leads to the target"),
    "velocity_shock_scatter": Quantity(
        "relative excess of the velocity shock found from another random draw"
    ),
    "displacement_shock_scatter": Quantity(
        "relative excess of the displacement shock found from another random draw"
    ),
    "velocity_shock_bound": velocity("velocity shock below which no orbit leaves the attractor"),
    "displacement_shock_bound": length(
        "displacement shock below which no orbit leaves the attractor"
    ),
    "velocity_shock_largest": velocity("largest velocity shock tried"),
    "displacement_shock_largest": length("largest displacement shock tried"),
    **{
        f"{kind}_shock_{when}_{name}": Quantity(
            f"{name} {when} the {kind} shock", scale="velocity" if name[0] == "v" else "length"
        )
        for kind in ("velocity", "displacement")
        for when in ("before", "after")
        for name in ("x", "y", "vx", "vy")
    },
    **{
        f"{kind}_shock_{when}": Quantity(
            f"displacement and velocity of all coordinates {when} the {kind} shock"
        )
        for kind in ("velocity", "displacement")
        for when in ("before", "after")
    },
    **{
        f"{name}_{side}": Quantity(f"{side}est {name} at which the attractor exists")
        for name in WITH_EXTENTS
        for side in ("low", "high")
    },
    **{
        f"{name}_{side}_end": Quantity(f"how the attractor ends at the {side}est {name}", flags=END)
        for name in WITH_EXTENTS
        for side in ("low", "high")
    },
    "undecided_count": Quantity("number of undecided starts"),
    "undecided_fraction": Quantity("fraction of computed starts that are undecided"),
    "agreement": Quantity("fraction of labels unchanged when computed again with a smaller error"),
    "agreement_count": Quantity("number of labels computed again with a smaller step error"),
    "not_computed_count": Quantity("number of starts that were not simulated to the end"),
    "response_count": Quantity("number of starts that end on a response of the kind"),
    "response_fraction": Quantity("fraction of computed starts that end on a response of the kind"),
    "response_fraction_error": Quantity("standard error of the fraction of the kind of response"),
    # limit cycles
    "cycle_period": time("period of the limit cycle on the rotating axes"),
    "cycle_radius_min": length("smallest distance from the bearing axis"),
    "cycle_radius_max": length("largest distance from the bearing axis"),
    "cycle_response": Quantity("kind of response", flags=RESPONSE),
    "cycle_stability": Quantity("stability of the limit cycle", flags=STABILITY),
    "cycle_contact_count": Quantity("number of contacts in a period"),
    "cycle_t": time("time since the start of the period"),
    "period_error": time("estimated error of the period"),
    "impulse_per_period": impulse("impulse of the contact force in a period"),
    "multiplier": Quantity("number of the multiplier, by falling modulus"),
    "multiplier_real": Quantity("real part of the multiplier"),
    "multiplier_imag": Quantity("imaginary part of the multiplier"),
    "multiplier_error": Quantity("estimated error of the multiplier"),
    "trace": Quantity("trace of the monodromy matrix"),
    "residual": Quantity("distance of the end of a period from its start, relative to its size"),
    "trivial_defect": Quantity("distance of the trivial multiplier, as integrated, from 1"),
    "symplectic_defect": Quantity(
        "distance of the monodromy matrix, as integrated, from a conformally symplectic one"
    ),
    "line": Quantity("number of the line of the spectrum, in order of frequency"),
    "line_kind": Quantity("kind of the line of the spectrum", flags=LINE_KIND),
    "side_line_over_spin": Quantity(
        "frequency of the strongest line other than that of the spin, over the spin speed, "
        "negative for backward whirl"
    ),
    # branches of limit cycles, and their bifurcations
    "special": Quantity("number of the special point, in order along the branch"),
    "special_speed": speed("spin speed at the special point"),
    "special_kind": Quantity("kind of the special point", flags=SPECIAL),
    "special_value": Quantity("continued parameter at the special point", ""),
    "special_second_value": Quantity("second continued parameter at the special point", ""),
    "special_period": time("period at the special point"),
    "special_point": Quantity("number of the point of the branch before the special one"),
    "special_state": Quantity(
        "displacement and velocity of all coordinates, and speeds of races, at the special point"
    ),
    "special_radius_min": length("smallest distance from the bearing axis at the special point"),
    "special_radius_max": length("largest distance from the bearing axis at the special point"),
    "slope": Quantity("rate of the continued parameter along the branch, by arclength"),
    # comparison
    "matched_branch": Quantity("number of the branch with the response, -1 if none"),
    "amplitude_error": Quantity("simulated minus exact amplitude, relative to the exact one"),
    "phase_error": Quantity("simulated minus exact phase lag", "radian"),
    "branch_amplitude_error": Quantity(
        "simulated minus exact amplitude on each branch, relative to the exact one"
    ),
    "branch_phase_error": Quantity("simulated minus exact phase lag on each branch", "radian"),
    "exact_amplitude": length("amplitude of each exact synchronous whirl"),
    "exact_offset": length("exact distance below the bearing axis of the mean position"),
    "exact_phase_lag": Quantity("phase lag of each exact synchronous whirl", "radian"),
    "lies_on": Quantity("kind of exact response that matches the simulated one", flags=EXACT),
    "exact_period": time("period of the exact limit cycle"),
    "exact_radius_min": length("smallest distance from the bearing axis on the exact limit cycle"),
    "exact_radius_max": length("largest distance from the bearing axis on the exact limit cycle"),
    "digits": Quantity("decimal digits to which simulated and exact response agree"),
}
# What may vary between drops, in words.
OF_DROP = {
    "phase": "angle of the rotor", "friction": "friction coefficient",
    "contact_damping": "contact damping", "unbalance_factor": "factor of the unbalance",
    "clearance_factor": "factor of the clearances",
}  # fmt: skip
# Figures of a bearing in a drop, of which many drops give statistics.
OF_BEARING = (
    "contact_count", "total_contact_time", "longest_contact_time",
    "largest_force", "largest_force_time", "mean_contact_force", "largest_impulse", "total_impulse",
    "total_heat", "total_contact_loss", "first_roll_time", "largest_race_speed", "race_speed_time",
    "whirl_turns", "whirl_speed", "rest_time", "excursion",
)  # fmt: skip
QUANTITIES |= {
    f"{name}_{end}": replace(QUANTITIES[name], long_name=f"{words}: {QUANTITIES[name].long_name}")
    for name in (*OF_BEARING, "node_excursion")
    for end, words in {
        "mean": "mean over drops", "mean_error": "standard error of the mean over drops",
        "mean_low": "lower end of the mean over drops",
        "mean_high": "upper end of the mean over drops",
        "quantile": "quantile over drops", "quantile_low": "lower end of a quantile over drops",
        "quantile_high": "upper end of a quantile over drops",
        "min": "smallest over drops", "max": "largest over drops",
        "mean_change": "change on coarser grids of the mean over drops",
    }.items()
}  # fmt: skip
QUANTITIES |= {
    f"{name}_{end}_drop": Quantity(
        f"number of the drop with the {words} value: {QUANTITIES[name].long_name}"
    )
    for name in (*OF_BEARING, "node_excursion")
    for end, words in (("min", "smallest"), ("max", "largest"))
}


# What a special point of a branch or curve says of the parameters that vary, in their units.
SPECIAL_VALUES = ("special_value", "special_second_value")


def unit_of(name: str, unit: str) -> str:
    """Return the unit of a variable as people read it: that of an angular speed is rad/s.

    Examples
    --------
    >>> unit_of("whirl_speed", "s-1"), unit_of("growth_rate", "s-1"), unit_of("speed", "1")
    ('rad/s', 's-1', '1')
    """
    known = QUANTITIES.get(name)
    return "rad/s" if unit == "s-1" and known is not None and known.angular else unit
