"""What laboratories name otherwise is met with what to write, other unknown names with the nearest known one."""

import pytest

import hlcs
from hlcs.files.other_words import in_place_of, in_place_of_column

BODY = '[body]\nshape = "sphere"\nradius = 0.02\nmass = 0.01\n'


@pytest.mark.parametrize(
    ("toml", "header", "told"),
    [
        (BODY.replace("radius = 0.02", "diameter = 0.04"), "t_s,z_m", "body.diameter: unknown key; write radius, half of it"),
        (BODY, "t_s,v_m_s", "unknown column 'v_m_s'; velocities are not read"),
        (BODY, "t_s,z_m,trial_no", "unknown column 'trial_no'; leave it out: rows need no numbers"),
        (BODY, "t_s,z_m,day", "unknown column 'day'; in a table write group"),
        (BODY.replace("mass", "mas"), "t_s,z_m", "body.mas: unknown key; the nearest known key is 'mass'"),
    ],
)
def test_of_a_quantity_that_files_do_not_know_is_said_what_to_write(tmp_path, toml, header, told):
    (tmp_path / "r.csv").write_text(f"{header}\n0.0,1.0,1\n0.1,0.9,1\n")
    (tmp_path / "e.toml").write_text(f'kind = "trajectory"\n{toml}[[trial]]\nfile = "r.csv"\n')
    with pytest.raises(hlcs.InputError) as refused:
        hlcs.compare(tmp_path / "e.toml")
    assert told in str(refused.value)


def test_a_name_is_known_by_its_beginning_in_whole_words():
    assert "passage_time_s" in in_place_of("Terminal_speed_m_s") and "0.1047" in in_place_of("rpm")
    assert in_place_of("viscosity") == in_place_of("speed_m_s") == in_place_of("v") == ""  # a start has a velocity


def test_a_column_tells_rows_apart_by_its_whole_name_alone():
    for name in ("trial", "Trial no.", "run-number", "no", "repeat_id"):
        assert "leave it out" in in_place_of_column(name)
    for name in ("number_of_bounces", "run_time_s", "test_mass_kg", "day_length"):
        assert in_place_of_column(name) == ""
