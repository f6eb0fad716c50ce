"""What laboratories measure or name otherwise than these files do, and what to write in its place."""

import re

TURNS = "write angular_velocity = [x, y, z], in rad/s"
VELOCITIES = "velocities are not read: write positions in m, or accelerations where these were measured"
IN_PLACE = {  # beginning of a name of a key or a column, in lower case -> what to write
    "diameter": "write radius, half of it",
    "weight": "write mass, in kg",
    "spin": TURNS,
    "rpm": f"{TURNS}: a turn a minute is 0.1047 rad/s",
    "terminal_speed": "write the time between two marks, passage_time_s, with mark_1_m and mark_2_m, depths below the release",
}
OF_COLUMNS = IN_PLACE | dict.fromkeys(("v", "vx", "vy", "vz"), VELOCITIES)  # of a start the file may state a velocity
NUMBERS = "leave it out: rows need no numbers, and those of a table with equal inputs are repeats"
SERIES = "in a table write group: what was measured under the same conditions; a recording has its group in the experiment file"
OF_ROWS = {  # whole name of a column that tells rows apart -> what to do with it
    **dict.fromkeys(("repeat", "repetition", "replicate", "trial", "run", "test", "no", "nr", "number", "index", "id"), NUMBERS),
    **dict.fromkeys(("series", "session", "day", "date", "person", "student", "team", "observer"), SERIES),
}


def in_place_of(name, known=IN_PLACE):
    """What to write in place of a name that files do not know, in words; "" where nothing is known of it. known: as IN_PLACE."""
    words = str(name).strip().lower().split("_")
    beginnings = ("_".join(words[:count]) for count in range(len(words), 0, -1))
    return next((known[each] for each in beginnings if each in known), "")


def in_place_of_column(name):
    """The same of a column: of one that tells rows apart, such as "trial" or "Trial no.", too."""
    first, *others = re.split(r"[\s_-]+", str(name).strip().lower().rstrip("."))
    numbered = set(others) <= {"no", "nr", "number", "id"}
    return (OF_ROWS.get(first, "") if numbered else "") or in_place_of(name, OF_COLUMNS)
