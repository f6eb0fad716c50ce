"""What people write above the columns of a spreadsheet, and the columns of the project that they mean."""

from hlcs.data.outcome_tables import SD
from hlcs.data.quantities import INPUTS, OUTCOMES
from hlcs.data.recordings import ACCELERATIONS, COLUMNS, PIXELS
from hlcs.importing.units import KNOWN, SUFFIXES, UNITS, quantity_of, split_unit
from minibullet.errors import nearest, shown

LEAST_LETTERS = 4  # of a word that may be misspelt: of three letters any other is one away
ALIKE = 0.8  # likeness of two words, 0 to 1, from which one may be the other misspelt: one letter of five

WORDS = {  # what people write above a column, in English, German, French, Spanish, Italian and Portuguese -> the column
    "t_s": "t, time, zeit, laufzeit, temps, tiempo, tempo, time stamp, timestamp",
    "frame": "frame, frame number, bild, bildnummer, image, cuadro, fotograma, quadro",
    "x_m": "x, x position, position x, x pos, pos x, x-koordinate, x coordinate, posición x, posizione x, posição x",
    "y_m": "y, y position, position y, y pos, pos y, y-koordinate, y coordinate, posición y, posizione y, posição y",
    "z_m": "z, z position, position z, z pos, pos z, z-koordinate, z coordinate, posición z, posizione z, posição z, "
    "height, höhe, hoehe, h, hauteur, altura, altezza, quota, elevation",
    "qw": "q0, quaternion w",
    "qx": "q1, quaternion x",
    "qy": "q2, quaternion y",
    "qz": "q3, quaternion z",
    "height_m": "drop height, release height, fall height, fallhöhe, fallhoehe, hauteur de chute, altura de caída, "
    "altezza di caduta, altezza di rilascio, altura de queda",
    "fall_time_s": "fall time, falling time, drop time, time of fall, fallzeit, temps de chute, tiempo de caída, "
    "tempo di caduta, tempo de queda",
    "rebound_height_m": "rebound height, bounce height, rebound, rücksprunghöhe, rueckprallhoehe, rückprallhöhe, "
    "hauteur de rebond, hauteur du rebond, hauteur de rebondissement, altura de rebote, altura del rebote, altezza di rimbalzo, "
    "altezza del rimbalzo, altura do ressalto, altura de ressalto",
    "stop_distance_m": "stop distance, stopping distance, sliding distance, rutschweg, bremsweg, distance d'arrêt, "
    "distancia de frenado, distanza di arresto, distância de parada",
    "range_m": "range, throwing distance, landing distance, carry, carry distance, wurfweite, schussweite, portée, "
    "alcance, gittata",
    "slide_time_s": "slide time, sliding time, rutschzeit, gleitzeit, temps de glissement, tiempo de deslizamiento, "
    "tempo di scivolamento, tempo de deslizamento",
    "rest_height_m": "rest height, resting height, ruhehöhe, hauteur de repos, altura de reposo",
    "mass_kg": "mass, masse, masa, massa, m",
    "radius_m": "radius, rayon, radio, raggio, raio, ball radius, bead radius, sphere radius, kugelradius",
    "mark_1_m": "first mark, upper mark, marke 1, erste marke, obere marke, marque 1, marca 1",
    "mark_2_m": "second mark, lower mark, marke 2, zweite marke, untere marke, marque 2, marca 2",
    "spin_rad_s": "spin, spin rate, backspin",
    "speed_m_s": "speed, start speed, initial speed, launch speed, ball speed, initial velocity, launch velocity, "
    "geschwindigkeit, startgeschwindigkeit, anfangsgeschwindigkeit, abwurfgeschwindigkeit, "
    "vitesse, vitesse initiale, velocidad, velocidad inicial, "
    "velocità, velocità iniziale, velocidade, velocidade inicial",
    "angle_deg": "angle, launch angle, winkel, abwurfwinkel, angle de tir, ángulo, ángulo de lanzamiento, "
    "angolo, angolo di lancio, ângulo, ângulo de lançamento",
    "bounce": "bounce, bounce number, bounce no, number of bounce, impact, aufprall, nummer des aufpralls, rebond, bote, "
    "rimbalzo, ressalto",
    "distance_m": "distance, strecke, weg, abstand, distancia, distanza, distância",
    "group": "group, gruppe, groupe, grupo, gruppo, series, serie, day, tag, person, personne, persona, observer, beobachter, "
    "experimenter, operator, student, schüler, élève, alumno, studente, aluno, team, équipe, equipo, squadra, equipe",
}
DIAMETERS = {  # halved, they are radius_m
    f"{whose}{word}"
    for word in ("diameter", "durchmesser", "diamètre", "diámetro", "diametro", "diâmetro")
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


def meaning(word, unit=""):
    """The column that a word means, None where nobody knows, or its unit is of something else: a "Tempo [m/s]" is no time."""
    name = MEANING.get(word)
    fits = name is None or unit not in KNOWN or unit in UNITS[quantity_of(name)] or unit in UNITS["pixels"]
    return name if fits else None


def misspelt(cell, known):
    """What to do where a name is nearly one that is known, and its column is none of those that are there; "" elsewhere."""
    word, unit = split_unit(cell)
    near = nearest(word, [each for each in MEANING if len(each) >= LEAST_LETTERS], ALIKE) if len(word) >= LEAST_LETTERS else None
    name = near and meaning(near, unit)
    return f"; where it is '{near}', state \"{shown(cell)}={name}\"" if name and name not in known else ""


def column_of(cell):
    """The same of a cell above a column, its unit in it."""
    return meaning(*split_unit(cell))
