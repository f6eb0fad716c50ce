"""Motive's CSV: header, units, axes, quaternions and Euler angles, hidden frames, several bodies, markers alone."""

import numpy as np
import pytest

from minibullet import rotations

FIRST = (
    "Format Version,1.23,Take Name,drop 1,Capture Frame Rate,120.000000,Export Frame Rate,120.000000,"
    "Rotation Type,{rotation},Length Units,{unit},Coordinate Space,Global\n"
)
BODY = ",,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Marker,Marker,Marker\n"
NAME = ",,ball,ball,ball,ball,ball,ball,ball,ball,Unlabeled 7,Unlabeled 7,Unlabeled 7\n"
WHAT = ",,Rotation,Rotation,Rotation,Rotation,Position,Position,Position,Mean Marker Error,Position,Position,Position\n"
AXES = "Frame,Time (Seconds),X,Y,Z,W,X,Y,Z,,X,Y,Z\n"
ROWS = (
    "0,0.000000,0,0,0,1,100,1500,-200,0.1,1,2,3\n1,0.008333,0,0.6,0,0.8,110,1499.7,-201,0.1,1,2,3\n"
    "2,0.016667,,,,,,,,,1,2,3\n3,0.025,0.6,0,0,0.8,130,1497,-203,0.1,,,\n"
)


def motive(rows=ROWS, rotation="Quaternion", unit="Millimeters", what=(BODY, NAME, ",,1,1,1,1,1,1,1,1,2,2,2\n", WHAT, AXES)):
    """A take as Motive writes it."""
    return FIRST.format(rotation=rotation, unit=unit) + "\n" + "".join(what) + rows


def test_a_rigid_body_in_millimetres_with_y_up(imported):
    """(x, y, z) of the file are (x, -z, y): the turn by +90 degrees about x. The vector part of a quaternion turns alike, and
    its scalar, last in the file, comes first."""
    found, tables = imported(motive(), "optitrack")
    assert tables["drop.csv"] == {
        "t_s": ["0.0", "0.008333", "0.016667", "0.025"],
        "x_m": ["0.1", "0.11", "", "0.13"],
        "y_m": ["0.2", "0.201", "", "0.203"],
        "z_m": ["1.5", "1.4997", "", "1.497"],
        "qw": ["1.0", "0.8", "", "0.8"],
        "qx": ["0.0", "0.0", "", "0.6"],
        "qy": ["0.0", "0.0", "", "0.0"],
        "qz": ["0.0", "0.6", "", "0.0"],
    }
    told = str(found)
    assert "y of the file points up" in told and "pivot of each rigid body is the centre of mass" in told
    assert "1 sample of 'drop' was lost" in told


@pytest.mark.parametrize(("unit", "height"), [("Meters", "1500.0"), ("Centimeters", "15.0"), ("Millimeters", "1.5")])
def test_lengths_have_the_unit_of_the_header(imported, unit, height):
    assert imported(motive(unit=unit), "optitrack")[1]["drop.csv"]["z_m"][0] == height


def test_z_may_point_up_and_the_unit_may_be_wrong(imported):
    found, tables = imported(motive(unit="Meters"), "optitrack", up="z", length_unit="mm")
    assert [tables["drop.csv"][name][0] for name in ("x_m", "y_m", "z_m")] == ["0.1", "1.5", "-0.2"]
    assert tables["drop.csv"]["qy"][1] == "0.6"
    assert "lengths in mm, as --length-unit says, though the file says meters" in str(found)


@pytest.mark.parametrize("order", ["XYZ", "XZY", "YXZ", "YZX", "ZXY", "ZYX"])
def test_euler_angles_are_turns_about_the_axes_of_the_turned_body(imported, order):
    """Matrices multiplied by hand: R = R_first R_second R_third for turns about the body's own axes."""
    degrees = {"X": 20.0, "Y": -35.0, "Z": 50.0}

    def about(letter):
        c, s = np.cos(np.radians(degrees[letter])), np.sin(np.radians(degrees[letter]))
        return {
            "X": np.array([[1, 0, 0], [0, c, -s], [0, s, c]]),
            "Y": np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]),
            "Z": np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]),
        }[letter]

    what = (
        ",,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body,Rigid Body\n",
        ",,b,b,b,b,b,b\n",
        ",,1,1,1,1,1,1\n",
        ",,Rotation,Rotation,Rotation,Position,Position,Position\n",
        "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n",
    )
    rows = "0,0,20,-35,50,0,1,0\n1,0.01,20,-35,50,0,1,0\n2,0.02,,,,0,1,0\n"
    found, tables = imported(motive(rows, order, "Meters", what), "optitrack", up="z")
    q = [float(tables["drop.csv"][name][0]) for name in ("qw", "qx", "qy", "qz")]
    wanted = about(order[0]) @ about(order[1]) @ about(order[2])
    assert np.abs(rotations.matrix(np.array(q)) - wanted).max() < 1e-11  # twelve digits are written
    assert tables["drop.csv"]["qw"][2] == "" and tables["drop.csv"]["z_m"][2] == "0.0"
    assert "Euler angles in degrees" in str(found) and "[--rotation-order]" in str(found)


def test_turning_the_world_turns_orientations_with_it(imported):
    """A body axis that pointed along a direction of the file points along that direction, turned: R' = P R P^T."""
    q = np.array([0.5, 0.1, -0.7, 0.5])
    q /= np.linalg.norm(q)
    row = ",".join(f"{value:.9f}" for value in (*q[1:], q[0]))
    rows = "".join(f"{k},{0.01 * k},{row},1,2,3,0,1,2,3\n" for k in range(2))
    _, tables = imported(motive(rows, unit="Meters"), "optitrack")
    turned = np.array([float(tables["drop.csv"][name][0]) for name in ("qw", "qx", "qy", "qz")])
    turn = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    assert np.abs(rotations.matrix(turned) - turn @ rotations.matrix(q) @ turn.T).max() < 1e-8  # nine digits were given


def test_markers_are_read_where_there_is_no_rigid_body(imported):
    """Newer takes label the rows `Type`, `Name`, and add `Parent`."""
    what = (
        ",Type,Marker,Marker,Marker,Marker,Marker,Marker\n",
        ",Name,top,top,top,side,side,side\n",
        ",ID,A,A,A,B,B,B\n",
        ",Parent,,,,,,\n",
        ",,Position,Position,Position,Position,Position,Position\n",
        "Frame,Time (Seconds),X,Y,Z,X,Y,Z\n",
    )
    found, tables = imported(motive("0,0,1,2,3,4,5,6\n1,0.1,1,2,3,4,5,6\n", unit="Meters", what=what), "optitrack")
    assert tables["drop_top.csv"]["z_m"] == ["2.0", "2.0"] and tables["drop_side.csv"]["y_m"] == ["-6.0", "-6.0"]
    assert "each marker is the centre of mass" in str(found)


def test_without_a_column_of_times_the_frame_rate_gives_them(imported):
    what = (",,Marker,Marker,Marker\n", ",,a,a,a\n", ",,1,1,1\n", ",,Position,Position,Position\n", "Frame,,X,Y,Z\n")
    found, tables = imported(motive("6,,1,2,3\n12,,1,2,3\n", what=what), "optitrack")
    assert tables["drop.csv"]["t_s"] == ["0.05", "0.1"]
    assert "frame number over 120 1/s, the Export Frame Rate" in str(found)


@pytest.mark.parametrize("decimal", [".", ","])
def test_a_take_that_a_spreadsheet_saved_again_is_the_same(imported, decimal):
    _, wanted = imported(motive(), "optitrack")
    _, tables = imported("\ufeff" + motive().replace(",", ";").replace(".", decimal), "optitrack")
    assert tables == wanted


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("Frame,Time (Seconds),X\n0,0,1\n", ["drop.csv, row 1: begins with 'Frame'", "'Format Version, .., Take Name"]),
        (FIRST + "\n0,0,1\n", ["drop.csv, row 3: expected rows of type, name, ID", "export again with the header"]),
        (
            motive(what=(BODY.replace("Rigid Body", "Bone").replace("Marker", "Bone"), NAME, "\n", WHAT, AXES)),
            ["row 3", "columns of Bone; a Rigid Body or a Marker is needed"],
        ),
        (
            motive(ROWS.replace("0,0.6,0,0.8", "0,0.6,0,0.1")),
            ["drop.csv, row 9, columns Rotation X..W: a quaternion of length 0.6083"],
        ),
        (motive(ROWS.replace(",1499.7,", ",high,")), ["drop.csv, row 9, column Position Y: 'high' is not a number"]),
        (
            motive(what=(BODY, NAME, "\n", WHAT.replace("Mean Marker Error", "Position"), AXES.replace("Z,,X", "Z,X,X"))),
            ["drop.csv, row 4: Rigid Body 'ball' stands twice with Position X; give each a name of its own"],
        ),
        (motive(unit="Smoots"), ["drop.csv, row 1: Length Units: 'smoots' is not known as a unit of length"]),
    ],
)
def test_what_is_no_export_of_motive_is_refused_with_its_row(refused, text, words):
    refused(text, "optitrack", *words)


def test_euler_angles_without_their_order_are_asked_for(refused):
    what = (
        ",,Rigid Body,Rigid Body,Rigid Body\n",
        ",,b,b,b\n",
        ",,1,1,1\n",
        ",,Rotation,Rotation,Rotation\n",
        "Frame,Time (Seconds),X,Y,Z\n",
    )
    refused(
        motive("0,0,1,2,3\n", "Unknown", what=what), "optitrack", "Rotation Type 'Unknown'", "state --rotation-order, one of XYZ"
    )
    refused(motive(), "optitrack", "a quaternion; --rotation-order is for Euler angles", rotation_order="XYZ")
