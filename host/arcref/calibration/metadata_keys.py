"""The metadata keys of run files: each key stands here once, with its meaning, for readers, hints and the manual.

Numbers that only the user knows (what the certificates state, how well the autocollimator is aligned) reach the
uncertainty budget through these keys. Uncertainties are standard uncertainties (k=1) unless the key says `expanded`;
an expanded one is taken with k=2.
"""

import math

from arcref.calibration.metadata_key import (
    CLOSURE,
    CONDITIONS,
    EVERY,
    FACES,
    IDENTIFICATION,
    METHOD,
    POLYGON,
    SEEN,
    SUBDIVISION,
    THEODOLITE,
    UNCERTAINTY,
    MetadataKey,
)


def _text(name, group, meaning, kinds=EVERY):
    return MetadataKey(name, group, meaning, kinds)


def _number(name, group, meaning, unit, kinds=EVERY, lowest=-math.inf):
    return MetadataKey(name, group, meaning, kinds, unit, lowest)


METADATA_KEYS = (
    _text("encoder_serial", IDENTIFICATION, "serial number of the encoder"),
    _text("encoder_model", IDENTIFICATION, "model of the encoder"),
    _text("encoder_maker", IDENTIFICATION, "maker of the encoder"),
    _text("certificate_number", IDENTIFICATION, "number of the report, as the laboratory counts them"),
    _text("customer", IDENTIFICATION, "for whom the encoder was calibrated"),
    _text("laboratory", IDENTIFICATION, "who calibrated it, and where"),
    _text("operator", IDENTIFICATION, "who took the readings"),
    _text("date", IDENTIFICATION, "day of the readings, YYYY-MM-DD"),
    _text("run", IDENTIFICATION, "what the run is: as found, as left, verification ..."),
    _text("polygon_serial", IDENTIFICATION, "serial number of the polygon", FACES),
    _text("polygon_certificate", IDENTIFICATION, "certificate of the polygon: number, date, laboratory", FACES),
    _text("autocollimator_serial", IDENTIFICATION, "model and serial number of the autocollimator", FACES),
    _text("autocollimator_certificate", IDENTIFICATION, "certificate of the autocollimator", FACES),
    _text("theodolite_serial", IDENTIFICATION, "model and serial number of the theodolite", (THEODOLITE,)),
    _text("theodolite_certificate", IDENTIFICATION, "certificate of the theodolite", (THEODOLITE,)),
    _text("source", IDENTIFICATION, "publication or file the readings come from"),
    _text("table", IDENTIFICATION, "which table of the source"),
    _text("note", IDENTIFICATION, "anything else that a reader should know"),
    _number("temperature_c", CONDITIONS, "mean temperature of the air during the run", "deg C"),
    _number("temperature_change_k", CONDITIONS, "largest change of the temperature during the run", "K", lowest=0),
    _number("humidity_percent", CONDITIONS, "relative humidity of the air", "%", lowest=0),
    _number("pressure_hpa", CONDITIONS, "pressure of the air", "hPa", lowest=0),
    _number("faces", METHOD, "number of faces of the polygon", "1", FACES, 3),
    _number("autocollimator_sign", METHOD, "+1: e = (a-a1) - (b-b1) + (c-c1); -1: c is subtracted", "1", SEEN, -1),
    _number("autocollimator_roll_arcmin", METHOD, "roll of the autocollimator: x gets roll times y", "arcmin", FACES),
    _number("autocollimator_y_sign", METHOD, "+1: y grows as the face looks up; -1: it falls", "1", (POLYGON,), -1),
    _number("closing_limit_arcsec", METHOD, "largest closing error that a round may have", "arcsec", FACES, 0),
    _number(
        "encoder_grade", METHOD, "accuracy grade of the encoder, 1 .. 7, for the tilt's tolerance", "1", (POLYGON,), 1
    ),
    _number(
        "required_accuracy_arcsec",
        METHOD,
        "accuracy asked of the encoder, when it has no grade",
        "arcsec",
        (POLYGON,),
        0,
    ),
    _text("screw_angles_deg", METHOD, "where the adjusting screws stand, from face 1 towards face 2", (POLYGON,)),
    _number("screw_radius_mm", METHOD, "how far the adjusting screws are from the axis", "mm", (POLYGON,), 0),
    _number("screw_pitch_mm", METHOD, "pitch of the adjusting screws", "mm", (POLYGON,), 0),
    _number(
        "setting_step_deg", METHOD, "turn of the polygon on the encoder from one setting to the next", "deg", (CLOSURE,)
    ),
    _number("datum_deg", METHOD, "reading at which the angles of mirror and axis are stated", "deg", (THEODOLITE,)),
    _number(
        "encoder_direction",
        METHOD,
        "+1: the reading grows as the shaft turns clockwise seen from above; -1: it falls",
        "1",
        (THEODOLITE,),
        -1,
    ),
    _number(
        "required_expanded_uncertainty_arcsec",
        METHOD,
        "largest expanded uncertainty (k=2) that the corrected angle may have",
        "arcsec",
        (THEODOLITE,),
        0,
    ),
    _text(
        "subdivision_corrected",
        METHOD,
        "yes: the readings had gone through the ROM's second table already; no by default",
        (*FACES, THEODOLITE),
    ),
    _number("samples_per_period", METHOD, "samples of the signals in one signal period", "1", (SUBDIVISION,), 1),
    _number("line_count", METHOD, "grating lines of the disc", "1", (SUBDIVISION,), 1),
    _number(
        "line_ripple_percent",
        UNCERTAINTY,
        "amplitude of speed ripple that comes once a grating line, in percent of the speed",
        "%",
        (SUBDIVISION,),
        0,
    ),
    _number("first_line", METHOD, "grating line at which the samples begin", "1", (SUBDIVISION,), 0),
    _number(
        "cosine_sign",
        METHOD,
        "+1: as the angle grows the cosine is a quarter of a line ahead of the sine; -1: it is behind",
        "1",
        (SUBDIVISION,),
        -1,
    ),
    _number(
        "count_zero_phase_deg",
        METHOD,
        "interpolated phase of the signals, 360 to a line, at which the count is a multiple of a line",
        "deg",
        (SUBDIVISION,),
    ),
    _number(
        "u_face_certificate_arcsec",
        UNCERTAINTY,
        "of one face deviation, from the polygon's certificate",
        "arcsec",
        (POLYGON,),
        0,
    ),
    _number(
        "expanded_face_certificate_arcsec",
        UNCERTAINTY,
        "the same as the certificate prints it, k=2",
        "arcsec",
        (POLYGON,),
        0,
    ),
    _number(
        "u_autocollimator_arcsec",
        UNCERTAINTY,
        "of one x reading, from the autocollimator's certificate",
        "arcsec",
        SEEN,
        0,
    ),
    _number(
        "expanded_autocollimator_arcsec", UNCERTAINTY, "the same as the certificate prints it, k=2", "arcsec", SEEN, 0
    ),
    _number(
        "u_repeatability_arcsec", UNCERTAINTY, "of one reading, when one round alone cannot show it", "arcsec", FACES, 0
    ),
    _number(
        "tilt_limit_arcsec", UNCERTAINTY, "tower tilt is below this, when there are no y readings", "arcsec", FACES, 0
    ),
    _number("u_autocollimator_roll_arcmin", UNCERTAINTY, "of the autocollimator's roll", "arcmin", FACES, 0),
    _number(
        "u_eccentric_mounting_arcsec",
        UNCERTAINTY,
        "of a reading, from the polygon's eccentric mounting",
        "arcsec",
        FACES,
        0,
    ),
    _number(
        "eccentricity_mm",
        UNCERTAINTY,
        "the polygon off the shaft's axis: how far the beam wanders over a face",
        "mm",
        FACES,
        0,
    ),
    _number(
        "u_face_flatness_arcsec_per_mm",
        UNCERTAINTY,
        "of a face's direction as the beam wanders over it",
        "arcsec/mm",
        FACES,
        0,
    ),
    _number(
        "u_temperature_arcsec",
        UNCERTAINTY,
        "of a reading, from the temperature's change during the run",
        "arcsec",
        EVERY,
        0,
    ),
    _number(
        "u_temperature_coefficient_arcsec_per_k",
        UNCERTAINTY,
        "of a reading, for each kelvin of change",
        "arcsec/K",
        EVERY,
        0,
    ),
    _number(
        "u_interpolation_arcsec",
        UNCERTAINTY,
        "of the encoder's error within a grating line",
        "arcsec",
        (*FACES, THEODOLITE),
        0,
    ),
    _number(
        "interpolation_amplitude_arcsec",
        UNCERTAINTY,
        "amplitude of that error, when it is known as one",
        "arcsec",
        (*FACES, THEODOLITE),
        0,
    ),
    _number(
        "u_face_deviation_arcsec",
        UNCERTAINTY,
        "of the faces from their nominal angles, as the polygon's maker states it",
        "arcsec",
        (CLOSURE,),
        0,
    ),
    _number("u_azimuth_arcsec", UNCERTAINTY, "of one azimuth reading of the theodolite", "arcsec", (THEODOLITE,), 0),
    _number("u_zenith_arcsec", UNCERTAINTY, "of one zenith reading of the theodolite", "arcsec", (THEODOLITE,), 0),
    _number("u_zenith_index_arcsec", UNCERTAINTY, "of the zenith circle's index", "arcsec", (THEODOLITE,), 0),
    _number(
        "u_levelling_arcsec", UNCERTAINTY, "of the theodolite's standing axis, off plumb", "arcsec", (THEODOLITE,), 0
    ),
    _number("u_collimation_arcsec", UNCERTAINTY, "of the theodolite's collimation", "arcsec", (THEODOLITE,), 0),
    _number(
        "u_mirror_walk_arcsec",
        UNCERTAINTY,
        "of an azimuth, as the beam walks over a mirror that is not flat",
        "arcsec",
        (THEODOLITE,),
        0,
    ),
    _number("u_count_zero_phase_deg", UNCERTAINTY, "of that phase, 360 to a line", "deg", (SUBDIVISION,), 0),
    _number(
        "speed_change_percent",
        UNCERTAINTY,
        "the speed changes by no more than this along one grating line",
        "%",
        (SUBDIVISION,),
        0,
    ),
)
"""Every key that some verb or the report knows. Other keys are kept and shown as they stand."""

KEYS_BY_NAME = {key.name: key for key in METADATA_KEYS}


def known_keys(kind: str) -> tuple[str, ...]:
    """Names of the keys that a run of `kind` uses."""
    return tuple(key.name for key in METADATA_KEYS if kind in key.kinds)
