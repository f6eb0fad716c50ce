"""Tables of people: names in any order and language, units in names or below them, decimal commas, recordings and experiments."""

import unicodedata

import pytest

import hlcs

GERMAN = "Zeit [s]; Höhe [cm]; Bemerkung\n0,00;150,0;los\n0,10;145,1;\n0,20;;verdeckt\n0,30;105,9;\n"
WANTED = {"t_s": ["0.0", "0.1", "0.2", "0.3"], "z_m": ["1.5", "1.451", "", "1.059"]}


def test_decimal_commas_and_centimetres(imported):
    found, tables = imported(GERMAN, "csv")
    assert tables["drop.csv"] == WANTED
    told = str(found)
    assert "decimals are written with a comma" in told and "column 'Bemerkung' is left out" in told
    assert "column 'Höhe [cm]' is z_m  [--column]" in told and "1 sample of 'drop' was lost" in told


@pytest.mark.parametrize(
    "text",
    [
        GERMAN.encode("cp1252"),
        GERMAN.encode("utf-16"),
        GERMAN.replace("; ", "\t").replace(";", "\t"),
        "Höhe (mm),t/ms\n1500,0\n1451,100\n,200\n1059,300\n",
        "height_cm,time_s\n150,0\n145.1,0.1\nNA,0.2\n105.9,0.3\n",
        "Fall of a ball\n\ntime,height\ns,mm\n0,1500\n0.1,1451\n0.2,-\n0.3,1059\n",
        'Zeit in s,Höhe in cm\n0,150\n"0,1","145,1"\n"0,2",\n"0,3","105,9"\n',
        "# made by hand\nz_m,t_s\n1.5,0\n1.451,0.1\nnan,0.2\n1.059,0.3\n",
        "sep=;\n" + GERMAN,
        "Versuch;7\nvon;Anna\n" + GERMAN,
        "t,z,remark\ns,mm,-\n0,1500,first\n0.1,1451,\n0.2,null,\n0.3,1059,\n",
        '"time\n(s)","height\n(m)",remark\n0,1.5,"let\ngo"\n0.1,1.451,\n0.2,None,\n0.3,1.059,\n',
        "t/ms;z/mm\n0;1 500\n100;1\N{NO-BREAK SPACE}451,0\n200;\n300;1'059\n",
        "t/ms;z/mm\n0;1,500.0\n100;1,451.0\n200;\n300;1,059.0\n",
        "t/ms;z/mm\n0;1.500,0\n100;1.451,0\n200;\n300;1.059,0\n",
        "t z\n0 1,5\n0,1 1,451\n0,2 -\n0,3 1,059\n",
        "# t_s z_m\n0 1.5\n0.1 1.451\n0.2 nan\n0.3 1.059\n",
        "# t_s,z_m,remark\n0,1.5,nan\n0.1,1.451,0\n0.2,,0\n0.3,1.059,0\n",
        "#Kinovea Trajectory data export\n#T Z\n\n# Ball\n0 1,5\n0,1 1,451\n0,2 -\n0,3 1,059\n",
        "Time (sec.),Height (meter)\n0,1.5\n0.1,1.451\n0.2,<NA>\n0.3,1.059\n",
    ],
    ids=[
        "Windows",
        "UTF-16",
        "tabs",
        "mm and ms",
        "suffixes",
        "units below",
        "quoted commas",
        "own names",
        "Excel's first line",
        "a head of two columns",
        "units of some",
        "broken lines",
        "blanks and apostrophes",
        "English thousands",
        "German thousands",
        "blanks and decimal commas",
        "names in a comment",
        "a comment above a lost sample",
        "Kinovea",
        "words for units",
    ],
)
def test_one_recording_in_many_hands(imported, text):
    _, tables = imported(text, "csv")
    assert tables["drop.csv"] == WANTED


def test_without_units_si_is_assumed_and_an_option_says_otherwise(imported):
    text = "t,h\n0,1500\n100,1451\n"
    found, _ = imported(text, "csv")
    assert "t_s is in s: the file names no unit  [--time-unit]" in str(found)
    _, tables = imported(text, "csv", time_unit="ms", length_unit="mm")
    assert tables["drop.csv"] == {"t_s": ["0.0", "0.1"], "z_m": ["1.5", "1.451"]}


def test_y_beside_x_alone_points_up_and_beside_z_does_not(imported):
    _, tables = imported("t,x,y\n0,1,2\n1,1,3\n", "csv")
    assert tables["drop.csv"] == {"t_s": ["0.0", "1.0"], "x_m": ["1.0", "1.0"], "z_m": ["2.0", "3.0"]}
    _, tables = imported("t,x,y,z\n0,1,2,9\n1,1,3,8\n", "csv")
    assert tables["drop.csv"]["y_m"] == ["2.0", "3.0"] and tables["drop.csv"]["z_m"] == ["9.0", "8.0"]
    _, tables = imported("t,x,y,z\n0,1,2,9\n1,1,3,8\n", "csv", up="-z")
    assert tables["drop.csv"]["y_m"] == ["-2.0", "-3.0"] and tables["drop.csv"]["z_m"] == ["-9.0", "-8.0"]


def test_frame_numbers_are_times_with_a_frame_rate(imported, refused):
    _, tables = imported("frame,height [m]\n0,1.5\n12,1.45\n", "csv", frame_rate=240)
    assert tables["drop.csv"]["t_s"] == ["0.0", "0.05"]
    refused("frame,height [m]\n0,1.5\n12,1.45\n", "csv", "drop.csv, row 1: frame numbers but no times; state --frame-rate")


def test_a_column_of_outcomes_makes_a_table_with_one_experiment_a_row(imported):
    text = "Fallhöhe (cm);Fallzeit (ms);Masse [g];Gruppe\n50;319;57,7;Mo\n50;321;57,7;Mo\n100;452;57,7;Di\n150;;57,7;Di\n"
    found, tables = imported(text, "csv")
    assert found.kind == "outcomes"
    assert tables["measurements.csv"] == {
        "height_m": ["0.5", "0.5", "1.0"],
        "fall_time_s": ["0.319", "0.321", "0.452"],
        "mass_kg": ["0.0577", "0.0577", "0.0577"],
        "group": ["Mo", "Mo", "Di"],
    }
    text = found.experiment.read_text()
    assert "1 row without fall_time_s left out (row 5)" in text
    assert "# noise = 0.003" in text and "mass =" not in text  # two equal rows tell the noise; the table tells the mass


def test_without_replicates_the_noise_is_to_be_filled_in(imported):
    found, _ = imported("drop height [m],fall time [s]\n0.5,0.319\n1,0.452\n", "csv")
    assert [place.key for place in found.fill_in] == ["body.radius", "body.mass", "measurement.noise"]


def test_what_the_user_said_stands_in_the_file_as_it_is_typed(imported):
    """An option once for each of its values, in quotes where a shell needs them."""
    found, _ = imported(
        "h [cm],Zeit\n50,319\n100,452\n", "csv", column={"h [cm]": "height_m", "Zeit": "fall_time_s"}, time_unit="ms"
    )
    assert '# with --time-unit ms --column "h [cm]=height_m" --column Zeit=fall_time_s\n' in found.experiment.read_text("utf-8")


def test_the_user_says_what_a_column_is(imported):
    """Time and height in each row may be samples of one fall, or falls: the name alone cannot tell."""
    text = "h [cm],time [s]\n50,0.319\n50,0.321\n100,0.452\n"
    _, tables = imported(text, "csv", column={"time [s]": "fall_time_s"})
    assert tables["measurements.csv"] == {"height_m": ["0.5", "0.5", "1.0"], "fall_time_s": ["0.319", "0.321", "0.452"]}
    _, tables = imported("time [s],mark [mm],n\n0,1500,1\n0.1,1451,2\n", "csv", column={"mark [mm]": "z_m"})
    assert tables["drop.csv"]["z_m"] == ["1.5", "1.451"]


def test_constants_become_columns_of_a_table(imported):
    _, tables = imported("fall time [s]\tday\n0.45\tMo\n0.46\tTu\n", "csv", constant={"height_m": 1.0})
    assert tables["measurements.csv"]["height_m"] == ["1.0", "1.0"]


def test_angles_in_radians_are_degrees_in_a_table(imported):
    """0.5 rad = 28.6478897565 degrees."""
    _, tables = imported("angle [rad],slide time [s]\n0.5,0.81\n0.5,0.82\n", "csv")
    assert tables["measurements.csv"] == {"angle_deg": ["28.6478897565"] * 2, "slide_time_s": ["0.81", "0.82"]}


@pytest.mark.parametrize(
    ("head", "columns"),
    [
        ("Hauteur de chute [cm];Hauteur de rebond [cm]", ("height_m", "rebound_height_m")),
        ("Altura de caída (cm);Altura de rebote (cm)", ("height_m", "rebound_height_m")),
        ("Hauteur de chute (cm);Temps (s)", ("height_m", "fall_time_s")),
        ("Altura de caída (cm);Tiempo (s)", ("height_m", "fall_time_s")),
        ("Fallhöhe (cm);Zeit (s)", ("height_m", "fall_time_s")),
    ],
)
def test_drop_heights_in_any_language_beside_a_rebound_or_a_time_are_a_table(imported, head, columns):
    """Decimal commas and centimetres; a time beside the height of a drop is that of its fall: no position goes with it."""
    found, tables = imported(head + "\n50,0;31,9\n50,0;32,1\n100;65,2\n", "csv")
    scale = 1.0 if columns[1] == "fall_time_s" else 0.01
    rows = tables["measurements.csv"]
    assert [float(cell) for cell in rows[columns[0]]] == [0.5, 0.5, 1.0]
    assert [float(cell) for cell in rows[columns[1]]] == pytest.approx([31.9 * scale, 32.1 * scale, 65.2 * scale], rel=1e-12)
    assert "decimals are written with a comma" in str(found)


def test_times_and_speeds_without_a_position_are_refused_by_what_is_missing(refused):
    refused(
        "Temps;Vitesse\n0,5;0,319\n0,7;0,321\n",
        "csv",
        "row 1: t_s, speed_m_s, and nothing of where the body is; samples of a recording need a position, such as z_m",
    )


def test_a_time_beside_the_number_of_a_bounce_or_beside_marks_is_that_of_the_bounce_or_the_passage(imported):
    text = "Drop height (cm),Bounce,Time (s),Run\n30,1,0.25,A\n30,2,0.64,A\n50,1,0.32,A\n"
    found, tables = imported(text, "csv")
    assert tables["bounces.csv"] == {
        "height_m": ["0.3", "0.3", "0.5"], "bounce": ["1.0", "2.0", "1.0"], "bounce_time_s": ["0.25", "0.64", "0.32"]
    }  # fmt: skip
    assert "'Time (s)' is bounce_time_s, counted from the release" in str(found) and "'Run' is left out" in str(found)
    text = "Kugelradius [mm];Marke 1 [cm];Marke 2 [cm];Laufzeit [s];Person\n1,5;5;25;7,2;Anna\n2;5;25;4,1;Jo\n"
    assert imported(text, "csv")[1]["measurements.csv"] == {
        "radius_m": ["0.0015", "0.002"],
        "mark_1_m": ["0.05", "0.05"],
        "mark_2_m": ["0.25", "0.25"],
        "group": ["Anna", "Jo"],
        "passage_time_s": ["7.2", "4.1"],
    }


def test_no_column_is_taken_for_a_time_whose_unit_is_another(refused):
    told = 'state what each is with --column "NAME=COLUMN"; where each row is an experiment of its own, one is its outcome'
    refused("layers,mass (g),v_end (m/s)\n1,2,3\n2,4,5\n", "csv", told, "a final speed is none: give the time between two marks")
    refused("n,mass (g),Dauer [s]\n1,2,3\n2,4,5\n", "csv", '--column "Dauer [s]=t_s", or =slide_time_s')


def test_a_name_that_is_misspelt_is_left_out_with_the_one_that_it_may_be(imported):
    found, _ = imported("time (s),x (m),hight (m),hue\n0,1,2,3\n0.1,2,3,4\n", "csv")
    told = [one.text for one in found.assumptions]
    assert (
        "drop.csv: column 'hight (m)' is left out, its meaning is not known; where it is 'height', state \"hight (m)=z_m\""
        in told
    )
    assert "drop.csv: column 'hue' is left out, its meaning is not known" in told


@pytest.mark.parametrize(("rows", "column", "said"), [(7, {}, True), (7, {"time (s)": "t_s"}, False), (100, {}, False)])
def test_rows_that_may_each_be_a_drop_are_told_to_be_samples(imported, rows, column, said):
    """Heights and times that rise together, as a class writes them down."""
    text = "height (m);time (s)\n" + "".join(f"{0.1 * k};{(0.2 * k / 9.81) ** 0.5:.3f}\n" for k in range(1, rows + 1))
    found, tables = imported(text, "csv", column=column)
    assert any('state "time (s)=fall_time_s"' in one.text for one in found.assumptions) == said
    assert "t_s" in tables["drop.csv"]


def test_what_is_seen_from_above_is_asked_for_its_floor(imported):
    found, _ = imported("t,x,y\n0,1,2\n0.1,2,3\n", "csv", up="none")
    assert any(place.key == "surroundings.floor.height" for place in found.fill_in)


def test_what_all_files_share_is_assumed_once(imported):
    a, b = "t (s);X (mm)\n0,1;1\n0,2;2\n", "t (s);X (mm);note\n0,1;1;x\n0,2;3;y\n"
    told = [one.text for one in imported({"a.csv": a, "b.csv": b, "c.csv": b.replace("3", "4")}, "csv")[0].assumptions]
    assert [one for one in told if "X (mm)" in one] == ["all 3 files: column 'X (mm)' is x_m"]
    assert [one for one in told if "note" in one] == ["b.csv, c.csv: column 'note' is left out, its meaning is not known"]
    assert len(told) == len(set(told))


def test_every_column_that_tables_take_can_be_named_as_it_is(imported):
    from hlcs.data.quantities import INPUTS

    for name in INPUTS:
        _, tables = imported(f"{name},fall_time_s\n0.5,0.3\n0.5,0.31\n", "csv")
        table = tables["bounces.csv" if name == "bounce" else "measurements.csv"]
        assert table[name] == ["0.5", "0.5"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,1\n1,2\n",
         ["drop.csv, row 1: '0, 1'; expected a row with the names of two columns or more, such as Zeit [s]; Höhe [cm]"]),
        ("t,z\n", ["drop.csv, row 1: 't, z'; no row of numbers follows these names"]),
        ("t|z\n0|1\n", ["drop.csv, row 1: 't|z'; expected a row", "columns are separated by tabs, semicolons, commas or blanks"]),
        ("t,z\n0,00,1,5\n", ["drop.csv, row 2: 4 cells below 2 names; where decimals have a comma, columns need another"]),
        ("Zeit,Laune\n0,1\n", ["drop.csv, row 1: columns 'Zeit', 'Laune'; none is known as a position", '--column "Laune=z_m"']),
        ("height [cm],x [m]\n1,2\n2,3\n",
         ["drop.csv, row 1: a column of times, such as Zeit [s], is missing; there are z_m, x_m"]),
        ("t,z\n0,1\n0.1,1.2.3\n", ["drop.csv, row 3, column z_m: '1.2.3' is not a number; a date or a time of day"]),
        ("t;z\n0;1,5\n0,1;1.4\n", ["drop.csv, row 3, column z_m: '1.4' has a point where '1,5' in row 2 has a comma"]),
        ("t,z\n0,1\n00:00:01,2\n", ["drop.csv, row 3, column t_s: '00:00:01' is not a number; a date or a time of day: give"]),
        ("t,z\n0,1\n1,2 m\n", ["column z_m: '2 m' is not a number; write the number alone, its unit in the name of the column"]),
        ("t,z\n0,1\n####,2\n2,3\n", ["drop.csv, row 3, column t_s: '####' is not a number; write a number, or leave"]),
        ("t;z/mm\n0;1,002\n1;998\n", ["drop.csv, row 2, column z_m: '1,002' beside whole numbers below 1000: are its"]),
        ("t,z,z\n0,1,2\n1,2,3\n", ["drop.csv, row 1: column 'z' stands twice; give each recording a file"]),
        ("t,z\n0,1\n0,1\n", ["drop.csv, row 3, column t_s: 0 s after 0 s: the same time twice; where each row is an experiment"]),
        ("t,z\n0,1\n0.1,2\n0,3\n0.1,4\n",
         ["drop.csv, row 4, column t_s: 0 s after 0.1 s: time begins again; where recordings stand below one another"]),
        ("t [s],z [ell]\n0,1\n1,2\n", ["drop.csv, column z_m: 'ell' is not known as a unit of length; known are m,"]),
        ("t,height,z\n0,1,2\n1,1,2\n", ["drop.csv, row 1: both 'height' and 'z' would be z_m"]),
        ("t,z,x\n0,1,\n1,2,\n", ["drop.csv, row 1, column x: no number below it, to be x_m: delete the column"]),
        ("fall time,drop height\n0.3,0.5\n0.4,\n",
         ["drop.csv, row 3, column height_m: blank; every experiment needs its inputs"]),
        ("fall time,rebound height\n0.3,0.5\n", ["fall_time_s and rebound_height_m are both outcomes; a table has one"]),
        ("t,z,qw,qx\n0,1,1,0\n1,1,1,0\n", ["drop.csv: qw, qx without the rest"]),
        ('t,"z\n0,1\n', ["drop.csv, row 1: a quote is opened and not closed in its row"]),
        ("t,z\n" + "0,1," + "9" * 300_000, ["drop.csv, row 2: a line of 300,004 characters"]),
    ],
)  # fmt: skip
def test_what_cannot_be_read_is_refused_with_its_row(refused, text, words):
    refused(text, "csv", *words)


def test_a_minus_is_a_minus_however_it_is_printed(imported):
    _, tables = imported("t,z\n0,\N{MINUS SIGN}0.5\n1,-0.7\n", "csv")
    assert tables["drop.csv"]["z_m"] == ["-0.5", "-0.7"]


def test_three_decimals_are_decimals_where_nothing_says_thousands(imported):
    _, tables = imported("t;z;x\n0;1,002;1.5\n1;1,25;nan\n2;0,998;2\n".replace("1.5", "1,5"), "csv")
    assert tables["drop.csv"]["z_m"] == ["1.002", "1.25", "0.998"]
    _, tables = imported("t,z\n0,1.002\n1,nan\n2,1\n", "csv")
    assert tables["drop.csv"]["z_m"] == ["1.002", "", "1.0"]


def test_rows_that_are_passed_over_are_told(imported):
    found, _ = imported("Anna,7\nwho,what\nt,z\n0,1\n#0.5,2\n1,2\n", "csv")
    assert "what stands above the names of its columns is passed over (row 1, 2)" in str(found)
    assert "what begins with # is passed over, as a comment (row 5)" in str(found)


def test_a_column_that_is_not_there_is_told_with_those_that_are(refused):
    refused("t,z\n0,1\n1,2\n", "csv", "no column 'Höhe' (--column); there are 't', 'z'", column={"Höhe": "z_m"})


def test_the_folder_is_as_before_when_a_file_is_refused(imported, refused, tmp_path):
    imported(GERMAN, "csv")
    before = {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()}
    refused("t,z\n0,one\n", "csv")
    assert {path.name: path.read_bytes() for path in (tmp_path / "out").iterdir()} == before


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(hlcs.InputError, match="nowhere.csv: cannot be read"):
        hlcs.import_measurements(tmp_path / "nowhere.csv", "csv", tmp_path / "out")


def test_words_that_part_the_rows_of_a_table_are_offered_as_groups(imported):
    """Two balls in one table are two restitutions; a remark in a recording, and what every row says, part nothing."""
    table = "Ball;Land;Fallhöhe [cm];Rücksprunghöhe [cm]\nTennis;CH;100;55\nFlummi;CH;100;75\n"
    told = [one.text for one in imported(table, "csv")[0].assumptions if "meaning" in one.text]
    assert 'state "Ball=group"' in told[0] and told[1].endswith("its meaning is not known")
    grouped = imported(table, "csv", column={"Ball": "group"})[0].assumptions
    assert not any("=group" in one.text for one in grouped)


def test_a_word_whose_unit_is_of_something_else_is_not_taken_for_it(imported):
    """Tempo is a time in Italian and a speed in German."""
    found, tables = imported("Zeit [s];Höhe [m];Tempo [m/s]\n0;1;2\n1;1;3\n", "csv")
    assert list(tables.values())[0]["t_s"] == ["0.0", "1.0"] and "column 'Tempo [m/s]' is left out" in str(found)


def test_columns_of_unknown_meaning_are_told_in_one_line(imported):
    """An export with everything that a script derived: three are named, the others counted."""
    head = ";".join(f"derived {letter}" for letter in "abcde")
    told = [
        one.text
        for one in imported(f"Tiempo_segundos;X_metros;Y_cm;{head}\n0;1;2{';9' * 5}\n1;1;3{';9' * 5}\n", "csv")[0].assumptions
    ]
    left = [one for one in told if "left out" in one]
    assert len(left) == 1 and "columns 'derived a', 'derived b', 'derived c' and 2 more are left out, their" in left[0]
    assert any("'X_metros' is x_m" in one for one in told) and any("'Y_cm' is y_m" in one for one in told)


def test_what_is_no_outcome_is_refused_with_the_list_of_those_that_are(refused):
    """The period of a swing."""
    refused("Länge [cm];Periode [s]\n20;0,9\n40;1,27\n", "csv", "one is its outcome: fall_time_s", "cannot be compared")


SUNK = "0.05,39.0\n0.10,40.0\n0.15,41.0\n0.20,0\n0.25,43.0\n0.30,44.0\n0.35,0.000\n0.40,0\n"


def test_zeros_of_a_body_out_of_sight_are_missing_samples(imported):
    found, tables = imported(f"Time(sec),z_mm\n{SUNK}", "csv")
    assert tables["drop.csv"]["z_m"] == ["0.039", "0.04", "0.041", "", "0.043", "0.044"]
    assert "3 samples read 0 far from where the body was (the first in row 5)" in str(found)
    assert "lost" not in str(found) and "last sample" not in str(found)  # told once


@pytest.mark.parametrize(
    "rows",
    [
        "0,0\n0.1,0\n0.2,0.9\n0.3,1.1\n0.4,1.2\n",  # starts at the origin, and slows down
        "0,0.9\n0.1,0.7\n0.2,0.4\n0.3,0.0\n0.4,0\n",  # comes to rest there
        "0,0.2\n0.1,0.1\n0.2,0.0\n0.3,-0.1\n0.4,-0.2\n",  # passes through it
    ],
)
def test_a_body_that_is_at_the_origin_is_there(imported, rows):
    found, tables = imported(f"t_s,z_m\n{rows}", "csv")
    assert "" not in tables["drop.csv"]["z_m"] and "out of sight" not in str(found)


@pytest.mark.parametrize(
    "name", ["bead diameter (mm)", "Kugeldurchmesser [mm]", "Durchmesser/mm", "diamètre (mm)", "Diameter_mm"]
)
def test_half_a_diameter_is_the_radius_of_each_row(imported, name):
    """Beads of several sizes in one table: left out, one radius would have been asked for all of them."""
    found, tables = imported(f"{name},upper mark (cm),lower mark (cm),time (s)\n4,5,25,46.3\n10,5,25,7.4\n", "csv")
    assert tables["measurements.csv"]["radius_m"] == ["0.002", "0.005"]
    assert f"half of column '{name}' is radius_m  [--column]" in str(found) and "body.radius" not in str(found)


def test_a_slide_from_rest_asks_for_its_slope(imported):
    found, tables = imported("distance (m),sliding time (s)\n0.5,1.2\n1.0,1.7\n", "csv")
    assert tables["measurements.csv"]["angle_deg"] == ["fill in", "fill in"]
    assert "2 lines from 2 on: angle_deg" in str(found) and "--constant angle_deg=5" in str(found)
    for given in ({"constant": {"angle_deg": 5}}, {"constant": {"slope": 0.1}}, {"constant": {"speed_m_s": 1.5}}):
        assert (
            "fill in" not in imported("distance (m),sliding time (s)\n0.5,1.2\n", "csv", **given)[1]["measurements.csv"].values()
        )


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        ("drop height (cm),bounce 1 [s],bounce 2 [s]\n30,0.25,0.64\n50,0.32,\n", "bounce_time_s"),
        ("Fallhöhe cm;1. Aufprall;2. Aufprall\ncm;s;s\n30;0,25;0,64\n50;0,32;\n", "bounce_time_s"),
        ("height [m],rebond 1 (cm),rebond 2 (cm)\n0.3,25,64\n0.5,32,\n", "rebound_height_m"),
    ],
)
def test_bounces_beside_one_another_are_a_row_each_with_their_number(imported, text, outcome):
    """A bounce that was not read is left out."""
    found, tables = imported(text, "csv")
    wanted = {"height_m": ["0.3", "0.3", "0.5"], "bounce": ["1.0", "2.0", "1.0"], outcome: ["0.25", "0.64", "0.32"]}
    assert tables["bounces.csv"] == wanted and "are the bounces after one drop: a row each" in str(found)


def test_a_unit_may_stand_behind_a_blank(imported):
    _, tables = imported("Durchmesser mm,Marke 1 cm,Marke 2 cm,Zeit s\n4,10,30,1.52\n6,10,30,0.71\n", "csv")
    assert tables["measurements.csv"] == {
        "radius_m": ["0.002", "0.003"], "mark_1_m": ["0.1"] * 2, "mark_2_m": ["0.3"] * 2, "passage_time_s": ["1.52", "0.71"]
    }  # fmt: skip


def test_heights_beside_the_numbers_of_bounces_are_rebounds_of_one_drop(imported):
    found, tables = imported("Bounce number,Height (cm)\n1,57.3\n2,48.8\n3,41.3\n", "csv", constant={"height_m": 0.66})
    wanted = {"height_m": ["0.66"] * 3, "bounce": ["1.0", "2.0", "3.0"], "rebound_height_m": ["0.573", "0.488", "0.413"]}
    assert tables["bounces.csv"] == wanted and "column 'Height (cm)' is rebound_height_m  [--column]" in str(found)


def test_speeds_of_cars_are_in_miles_an_hour(imported):
    """1 mile is 1609.344 m, 1 foot 0.3048 m, both exactly."""
    _, tables = imported("Speed (mph),Stopping distance (ft)\n25,85\n", "csv")
    assert tables["measurements.csv"] == {"speed_m_s": ["11.176"], "stop_distance_m": ["25.908"]}
    assert imported("Speed [ft/s],Stopping distance (ft)\n10,85\n", "csv")[1]["measurements.csv"]["speed_m_s"] == ["3.048"]


def test_ranges_of_throws_need_the_speed_of_the_launch(imported):
    found, tables = imported("Launch angle (deg),Range (cm)\n30,210\n45,245\n", "csv")
    assert tables["measurements.csv"] == {
        "angle_deg": ["30.0"] * 1 + ["45.0"],
        "range_m": ["2.1", "2.45"],
        "speed_m_s": ["fill in"] * 2,
    }
    assert "--constant speed_m_s=5" in str(found)


def test_shots_of_a_launch_monitor_are_throws_with_a_spin(imported):
    """171 miles an hour, 2545 turns a minute and 282 yards: 1609.344 m / 3600 s, 2 pi / 60 s and 0.9144 m."""
    text = "Club,Ball Speed (mph),Launch Angle (deg),Spin Rate (rpm),Carry (yds)\nDriver,171,10.4,2545,282\n"
    row = {name: float(values[0]) for name, values in imported(text, "csv")[1]["measurements.csv"].items()}
    assert row == pytest.approx({"speed_m_s": 76.444, "angle_deg": 10.4, "spin_rad_s": 266.512, "range_m": 257.861}, abs=1e-3)


def test_units_say_which_column_could_be_a_time_and_which_a_position(refused):
    text = "Uhr (s),Position (m)\n0,1.2\n0.1,1.15\n"
    refused(text, "csv", 'such as --column "Position (m)=z_m" --column "Uhr (s)=t_s"')
    refused("20 cm,35 cm\n197,265\n198,265\n", "csv", "their names are values", "a column of their own")


@pytest.mark.parametrize("person", ["observer", "Schüler", "élève", "Student"])
def test_times_that_scatter_beside_heights_are_of_falls(imported, person):
    """Three readings of each height, by two persons: samples of one motion are taken one after another."""
    rows = [f"{height},{who},{0.45 * height**0.5 + 0.02 * (k % 2):.2f}" for height in (1, 2, 3) for who in "AB" for k in range(3)]
    _, tables = imported("\n".join([f"height [m],{person},time [s]", *rows]) + "\n", "csv")
    assert tables["measurements.csv"].keys() == {"height_m", "group", "fall_time_s"}
    assert tables["measurements.csv"]["group"][:6] == [*"AAABBB"]


@pytest.mark.parametrize(
    ("head", "asked"),
    [
        ("Bremsweg (cm)", "speed_m_s"),
        ("fall time (s)", "height_m"),
        ("rebound speed (m/s)", "impact_speed_m_s"),
        ("passage time (s)", "mark_2_m"),
    ],
)
def test_what_an_outcome_cannot_do_without_is_asked_for(imported, head, asked):
    _, tables = imported(f"mass (g),{head}\n20,1.2\n20,1.3\n", "csv")
    assert tables["measurements.csv"][asked] == ["fill in"] * 2


@pytest.mark.parametrize(("unit", "size"), [("s", 1.0), ("ms", 1e-3), ("us", 1e-6)])
def test_times_of_a_clock_count_from_the_first_sample(imported, unit, size):
    """60 pictures a second in June 2024: to a microsecond, of which a double has four in a time of 1.7e9 s."""
    begin = 1717243200.0
    rows = [f"{(begin + k / 60) / size:.3f};{1 - 4.905 * (k / 60) ** 2:.4f}" for k in range(12)]
    rows = rows if unit != "s" else [f"{begin + k / 60:.6f};{1 - 4.905 * (k / 60) ** 2:.4f}" for k in range(12)]
    found, tables = imported(f"time [{unit}];z [m]\n" + "\n".join(rows) + "\n", "csv")
    assert [float(t) for t in tables["drop.csv"]["t_s"]] == pytest.approx([k / 60 for k in range(12)], abs=2e-6)
    assert any("times count from the first sample" in str(each) for each in found.assumptions)


def test_a_lost_cell_between_blanks_is_refused(refused):
    """x would be read as z, and z as lost."""
    lines = ["t x z", "0.0 0.3 1.25", "0.1      1.20", "0.2 0.5 1.05"]
    refused("\n".join(lines) + "\n", "csv", "row 3: 2 cells below 3 names", "write nan")


def test_a_remark_at_the_end_of_one_row_is_no_column(imported):
    _, tables = imported("time (s),z (m),note\n0.0,1.0\n0.1,0.95,first\n0.2,0.80\n", "csv")
    assert tables["drop.csv"]["z_m"] == ["1.0", "0.95", "0.8"]


def test_the_least_time_is_no_time_in_minutes(refused):
    """t_min may be either: nothing says which."""
    refused("height_m,t_min\n1.0,0.45\n1.5,0.55\n2.0,0.64\n", "csv", "'t_min'")


def test_a_diameter_that_is_called_a_radius_is_halved_and_that_is_told(imported):
    text = "Durchmesser der Kugel [mm];height_m;fall_time_s\n40;1.0;0.452\n40;1.5;0.553\n60;1.5;0.554\n"
    found, tables = imported(text, "csv", column={"Durchmesser der Kugel [mm]": "radius_m"})
    assert [float(radius) for radius in tables["measurements.csv"]["radius_m"]] == [0.02, 0.02, 0.03]
    assert any("half of column 'Durchmesser der Kugel [mm]' is radius_m" in str(each) for each in found.assumptions)
    text = text.replace("Durchmesser der Kugel", "halber Durchmesser")
    _, tables = imported(text, "csv", column={"halber Durchmesser [mm]": "radius_m"})
    assert float(tables["measurements.csv"]["radius_m"][0]) == 0.04


def test_densities_and_viscosities_have_units(imported):
    text = "density of the oil (g/cm3),eta (mPa s),height_m,fall_time_s\n0.96,800,0.3,1.5\n0.97,900,0.3,1.6\n0.97,900,0.4,2.1\n"
    stated = {"density of the oil (g/cm3)": "fluid_density_kg_m3", "eta (mPa s)": "fluid_viscosity_pa_s"}
    _, tables = imported(text, "csv", column=stated)
    (table,) = tables.values()
    assert [float(each) for each in table["fluid_density_kg_m3"]] == [960.0, 970.0, 970.0]
    assert [float(each) for each in table["fluid_viscosity_pa_s"]] == [0.8, 0.9, 0.9]


def test_an_umlaut_is_one_letter_however_it_was_saved(imported):
    """As one sign, or as a letter and two dots, in the file and in what is stated."""
    text = "t (s),Höhe über Tisch (m)\n0.0,1.0\n0.1,0.95\n0.2,0.80\n"
    for form, other in (("NFC", "NFD"), ("NFD", "NFC")):
        stated = {unicodedata.normalize(other, "Höhe über Tisch (m)"): "z_m"}
        _, tables = imported(unicodedata.normalize(form, text), "csv", column=stated)
        assert tables["drop.csv"]["z_m"] == ["1.0", "0.95", "0.8"]


def test_times_of_a_quick_clock_that_were_rounded_make_no_table_of_falls(refused):
    """200 readings a second, written to hundredths: each time stands twice."""
    rows = "".join(f"{0.01 * (k // 2):.2f},{1 - 0.001 * k:.3f}\n" for k in range(12))
    refused("time (s),height (m)\n" + rows, "csv", "the same time twice")


def test_a_speed_is_not_offered_as_a_height(refused):
    told = refused("t (s),vz (m/s)\n0.0,0.0\n0.1,-1.0\n0.2,-2.0\n", "csv", "none is known as a position")
    assert "vz (m/s)=z_m" not in told


def test_the_row_below_the_names_of_this_project_says_their_units(imported):
    found, tables = imported("t_s,z_m\nms,mm\n0,1000\n100,950\n200,800\n", "csv")
    assert tables["drop.csv"] == {"t_s": ["0.0", "0.1", "0.2"], "z_m": ["1.0", "0.95", "0.8"]}
    assert sum("as the row below its name says" in str(each) for each in found.assumptions) == 2


def test_accelerations_may_be_in_multiples_of_g(imported):
    _, tables = imported("t (s),ax_m_s2,az_m_s2\ns,g,g\n0,0,1\n0.1,0,1.1\n0.2,0,1\n", "csv")
    assert [float(each) for each in tables["drop.csv"]["az_m_s2"]] == pytest.approx([9.80665, 10.787315, 9.80665])


def test_a_column_is_left_out_where_the_user_says_so(imported, refused):
    """Of two outcomes one; a temperature that has the letter of the time."""
    text = "height_m,fall_time_s,rebound_height_m\n1.0,0.452,0.5\n1.5,0.553,0.74\n"
    refused(text, "csv", "are both outcomes")
    _, tables = imported(text, "csv", column={"rebound_height_m": ""})
    assert set(tables["measurements.csv"]) == {"height_m", "fall_time_s"}
    _, tables = imported("t (s),T (°C),z (m)\n0.0,20,1.0\n0.1,20,0.95\n0.2,20,0.8\n", "csv", column={"T (°C)": ""})
    assert tables["drop.csv"]["t_s"] == ["0.0", "0.1", "0.2"]
    refused(text, "csv", "no column 'Höhe'", column={"Höhe": ""})
    runs = "Latest: Time (s),Latest: T (C),Latest: Height (m)\n0.0,20,1.0\n0.1,20,0.95\n0.2,20,0.8\n"
    _, tables = imported(runs, "csv", column={"T (C)": ""})
    assert next(iter(tables.values()))["t_s"] == ["0.0", "0.1", "0.2"]


@pytest.mark.parametrize("title", ["Drop; third try", "Drop\tthird try", "Fall, 3. Versuch"])
def test_a_title_does_not_say_what_separates_the_columns(imported, title):
    for sign in ";,\t":
        lines = [title, sign.join(["t (s)", "z (m)"]), *(sign.join([str(0.1 * k), str(1 - 0.05 * k)]) for k in range(3))]
        _, tables = imported("\n".join(lines) + "\n", "csv")
        assert [float(z) for z in tables["drop.csv"]["z_m"]] == pytest.approx([1.0, 0.95, 0.9])
    for sign in ";\t":
        rows = [
            "Kugel, Holz",
            title,
            sign.join(["Zeit [s]", "Höhe, gemessen [m]"]),
            *(f"0,0{k}{sign}1,{50 - k}" for k in range(3)),
        ]
        _, tables = imported("\n".join(rows) + "\n", "csv", column={"Höhe, gemessen [m]": "z_m"})
        assert [float(z) for z in tables["drop.csv"]["z_m"]] == pytest.approx([1.5, 1.49, 1.48])
