"""What people write above the columns of a spreadsheet, and the columns of the project that they mean."""

from hlcs.data.outcome_tables import SD
from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, PIXELS
from hlcs.importing.units import SUFFIXES

WORDS = {  # what people write above a column, in English, German, French and Spanish -> the column
    "t_s": "t, time, zeit, laufzeit, temps, tiempo, time stamp, timestamp",
    "frame": "frame, frame number, bild, bildnummer, image",
    "x_m": "x, x position, position x",
    "y_m": "y, y position, position y",
    "z_m": "z, z position, position z, height, höhe, hoehe, h, hauteur, altura, elevation",
    "qw": "q0, quaternion w",
    "qx": "q1, quaternion x",
    "qy": "q2, quaternion y",
    "qz": "q3, quaternion z",
    "height_m": "drop height, release height, fall height, fallhöhe, fallhoehe, hauteur de chute, altura de caída",
    "fall_time_s": "fall time, falling time, drop time, time of fall, fallzeit, temps de chute, tiempo de caída",
    "rebound_height_m": "rebound height, bounce height, rebound, rücksprunghöhe, rueckprallhoehe, rückprallhöhe, "
    "hauteur de rebond, hauteur du rebond, hauteur de rebondissement, altura de rebote, altura del rebote",
    "stop_distance_m": "stop distance, stopping distance, sliding distance, rutschweg, bremsweg, distance d'arrêt, "
    "distancia de frenado",
    "range_m": "range, throwing distance, landing distance, carry, carry distance, wurfweite, schussweite, portée, alcance",
    "slide_time_s": "slide time, sliding time, rutschzeit, gleitzeit, temps de glissement, tiempo de deslizamiento",
    "rest_height_m": "rest height, resting height, ruhehöhe, hauteur de repos, altura de reposo",
    "mass_kg": "mass, masse, masa, m",
    "radius_m": "radius, rayon, radio, ball radius, bead radius, sphere radius, kugelradius",
    "mark_1_m": "first mark, upper mark, marke 1, erste marke, obere marke, marque 1, marca 1",
    "mark_2_m": "second mark, lower mark, marke 2, zweite marke, untere marke, marque 2, marca 2",
    "spin_rad_s": "spin, spin rate, backspin",
    "speed_m_s": "speed, start speed, initial speed, launch speed, ball speed, initial velocity, launch velocity, "
    "geschwindigkeit, startgeschwindigkeit, anfangsgeschwindigkeit, abwurfgeschwindigkeit, "
    "vitesse, vitesse initiale, velocidad, velocidad inicial",
    "angle_deg": "angle, launch angle, winkel, abwurfwinkel, angle de tir, ángulo, ángulo de lanzamiento",
    "bounce": "bounce, bounce number, bounce no, number of bounce, impact, aufprall, nummer des aufpralls, rebond, bote",
    "distance_m": "distance, strecke, weg, abstand, distancia",
    "group": "group, gruppe, groupe, grupo, series, serie, day, tag, person, personne, persona, observer, beobachter",
}
DIAMETERS = {  # halved, they are radius_m
    f"{whose}{word}"
    for word in ("diameter", "durchmesser", "diamètre", "diámetro")
    for whose in ("", "ball ", "bead ", "sphere ", "kugel")
}
MEANING = dict.fromkeys(DIAMETERS, "radius_m") | {
    word: column for column, words in WORDS.items() for word in (*words.split(", "), column.replace("_", " "))
}
# column -> the outcome that a time beside it is, the first that is there
TIMED = {"bounce": "bounce_time_s", "mark_2_m": "passage_time_s", "height_m": "fall_time_s"}
IN_RECORDINGS = (*COLUMNS, *PIXELS, *ACCELERATIONS, "frame")
IN_TABLES = (*INPUTS, *(f"{name}{SD}" for name in INPUTS), *OUTCOMES, "group")
for column in (*INPUTS, *OUTCOMES):  # "bounce time" is bounce_time_s: a column without the unit in its name
    ending = next((ending for ending in SUFFIXES if column.endswith(ending)), "")
    MEANING.setdefault(column.removesuffix(ending).replace("_", " "), column)
