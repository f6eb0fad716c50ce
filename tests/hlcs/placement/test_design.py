"""Design: probabilities from theory, the budget of its uncertainty, the choice, what is refused, and that runs are made once."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from hlcs import RPG, TPG, InputError, InputWarning, PlacementTest, laboratory
from hlcs.placement import design as designs
from hlcs.placement import design_budget, design_check
from hlcs.placement.design import Design, Wanted
from hlcs.placement.design_budget import ModelRatio, budget_of, line_through, model_ratio
from hlcs.placement.number_text import chance
from hlcs.placement.placement_file import read_placement_file
from hlcs.placement.run_store import Store

FLAT = {"height": 5.0, "nominal_diameters": (1.0,)}


def exact_ratio():
    """The ratio of a model that meets the laboratory exactly, three times."""
    table = laboratory("table2", grid="TPG")
    return model_ratio([(table, [table.height_over_dn])] * 3)


def test_units_of_a_size_that_is_hardly_meant_are_told_before_any_run():
    """As `hlcs place` tells it: millimetres in place of metres."""
    with pytest.warns(InputWarning, match="nominal_diameter = 38 m: a side of 35.575 m is hardly meant; usual is 0.005 to 10"):
        Wanted(height=5.0, nominal_diameters=(38.0,))


def test_the_line_is_that_of_least_squares(generator):
    friction, heights = np.linspace(0.36, 0.6, 9), generator.normal(5.0, 0.1, 9)
    line, found = line_through(friction, heights), stats.linregress(friction, heights)
    assert (line.slope, line.mean) == pytest.approx((found.slope, found.intercept + found.slope * 0.48), rel=1e-10)
    assert line.scatter / (0.24 * np.sqrt(15 / 16)) == pytest.approx(found.stderr, rel=1e-10)  # nine points: sum of squares


def test_equal_parts_of_two_degrees_of_freedom_have_four():
    """Welch-Satterthwaite: two equal variances of 2 degrees each have 4; Student's 95 % of those is 2.132 (any table)."""
    heights = np.array([5.0, 5.1, 5.05, 4.97])
    line = line_through(np.array([0.4, 0.5, 0.6, 0.7]), heights)
    target = line.mean - 2.1318 * np.sqrt(2.0) * line.one_more
    assert design_budget._exceeds(target, line, np.array([line.middle]), line.one_more, 2) == pytest.approx(0.95, abs=1e-4)


def test_what_one_more_run_reaches_is_promised_as_often_as_it_happens(generator):
    """Heights of twenty runs on a line with normal scatter, and one more run of a friction drawn evenly: it stays below the
    height that is promised with 90 % in 10 % of 1,000 cases; 3.3 standard deviations of that count are 3.1 %."""
    wanted = Wanted(**FLAT, probability=0.9)
    friction, ratio, below, cases = designs.frictions(20), exact_ratio(), 0, 1000
    for _ in range(cases):
        heights = 5.0 + 0.8 * (friction - 0.48) + generator.normal(0.0, 0.1, 20)
        promised = budget_of(wanted, friction, heights, heights, ratio).height_at_probability_m
        drawn = generator.uniform(0.36, 0.6)
        below += 5.0 + 0.8 * (drawn - 0.48) + generator.normal(0.0, 0.1) < promised
    assert below / cases == pytest.approx(0.1, abs=0.031)


def test_the_variance_is_the_sum_of_its_parts(generator):
    """An even spread of a width w has the variance w^2 / 12; seeds s^2 (1 + 1/n); the model (h s_r)^2 (1 + 1/3)."""
    friction = np.linspace(0.36, 0.6, 10)
    heights = 5.0 + 1.5 * (friction - 0.48) + generator.normal(0.0, 0.05, 10)
    table = laboratory("table2", grid="TPG")
    ratio = model_ratio([(table, [table.height_over_dn / r]) for r in (0.97, 0.98, 0.99)])
    budget, line = budget_of(Wanted(**FLAT), friction, heights, heights, ratio), line_through(friction, 0.98 * heights)
    parts = {
        "seeds": line.scatter**2 * 1.1,
        "friction": (line.slope * 0.24) ** 2 / 12,
        "model": (heights.mean() * 0.01) ** 2 * 4 / 3,
    }
    assert budget.height_m == pytest.approx(0.98 * heights.mean()) and budget.simulated_height_m == pytest.approx(heights.mean())
    assert budget.height_sd_m == pytest.approx(np.sqrt(sum(parts.values())))
    assert budget.variance_shares == pytest.approx({name: part / sum(parts.values()) for name, part in parts.items()})
    assert budget.reaches < budget.reaches_simulated  # lower, and less sure


def test_the_bed_is_not_corrected_with_the_height():
    """A model that is 2 % too high puts a crest 3 m above a bed at 10 m at 12.94 m, not at 12.74 m."""
    table = laboratory("table2", grid="TPG")
    ratio = model_ratio([(table, [table.height_over_dn / 0.98])] * 3)
    friction, heights = np.linspace(0.36, 0.6, 6), np.full(6, 3.0)
    budget = budget_of(Wanted(crest=12.0, nominal_diameters=(1.0,)), friction, heights, 10.0 + heights, ratio)
    assert budget.height_m == pytest.approx(12.94) and budget.simulated_height_m == pytest.approx(13.0)


def test_runs_that_left_no_top_do_not_reach():
    heights = np.array([5.0, 5.01, np.nan, 4.99, 5.02, np.nan, 5.0, 5.01])
    budget = budget_of(Wanted(**{**FLAT, "height": 2.0}), np.linspace(0.36, 0.6, 8), heights, heights, exact_ratio())
    assert budget.standing_share == 0.75 and budget.reaches == pytest.approx(0.75, abs=1e-6)
    assert np.isnan(budget.height_at_probability_m)  # no height is reached with 95 %
    none = budget_of(Wanted(**FLAT), np.linspace(0.36, 0.6, 8), np.full(8, np.nan), np.full(8, np.nan), exact_ratio())
    assert none.reaches == 0.0 and none.to_dict()["height_m"] is None


def test_the_models_error_is_measured_against_the_printed_tables():
    tables = [laboratory("table2", grid="TPG"), laboratory("table2", grid="RPG"), laboratory("table3", grid="TPG")]
    ratio = model_ratio([(table, [5.3, None, 5.5]) for table in tables])
    np.testing.assert_allclose(ratio.ratios, np.array([5.304, 5.174, 5.212]) / 5.4)  # the sums of the printed columns
    assert ratio.mean == pytest.approx(np.mean([5.304, 5.174, 5.212]) / 5.4)
    assert ratio.deviation == pytest.approx(np.std([5.304, 5.174, 5.212], ddof=1) / 5.4 * np.sqrt(4 / 3))
    assert ratio.degrees == 2 and ratio.campaigns[0].source.startswith("Table 2") and ratio.campaigns[2].tests == 9


# ---------------------------------------------------------------------------------- with runs whose heights are known
def known_run(test):
    """What a run would leave whose first layer is 1.3 Dn, the others 1 Dn (0.95 on RPG), and 0.1 more a unit of friction."""
    thick = (0.95 if test.grid == RPG else 1.0) + 0.1 * (test.friction - 0.48) + 0.002 * np.sin(97.0 * test.seed)
    heights = 1.3 + thick * np.arange(test.layers)
    units = [test.grid.units(test.rows, test.columns, layer) for layer in range(1, test.layers + 1)]
    dn = test.unit.nominal_diameter
    return {
        "plates": [{"height_over_dn": [h - 0.1, None, h + 0.1]} for h in heights],
        "layers": [
            {"level_m": h * dn + float(test.bottom.height(0.0, 0.0)), "units": n, "lost": j}
            for j, (h, n) in enumerate(zip(heights, units, strict=True))
        ],
    }


@pytest.fixture
def quick(monkeypatch):
    for module in (designs, design_check):
        monkeypatch.setattr(module, "result_of", known_run)
    monkeypatch.setattr(designs, "CAMPAIGN_REPEATS", 6)


def made(tmp_path, **wanted):
    return designs.design(Wanted(**{**FLAT, "repeats": 6, **wanted}), tmp_path / "designs.sqlite", workers=1)


def test_the_choice_reaches_the_height_with_least_concrete(quick, tmp_path):
    result = made(tmp_path, height=5.0, nominal_diameters=(0.9, 1.0, 1.2))
    rows = result.to_dataframe()
    good = rows[rows["reaches"] >= 0.95]
    assert 0 < len(good) < len(rows)
    assert result.chosen == good["concrete_m3_per_m2"].idxmin()
    assert np.diff(rows["concrete_m3_per_m2"]).min() > -1e-12
    five = rows[(rows["grid"] == "TPG") & (rows["layers"] == 5) & (rows["nominal_diameter_m"] == 1.0)].iloc[0]
    assert five["simulated_height_m"] == pytest.approx(5.3, abs=0.005)  # 1.3 + 4 x 1, seeds of 0.002
    assert five["concrete_m3_per_m2"] == pytest.approx(5 * TPG.packing_density)
    assert five["units_per_m2"] == pytest.approx(5 * TPG.packing_density)
    assert five["lost_share"] == pytest.approx((0 + 1 + 2 + 3 + 4) / (81 + 64 + 49 + 36 + 25))  # 9 x 9 units of layer 1


def test_one_run_stands_for_all_sizes_on_a_flat_bed_and_none_is_made_twice(quick, tmp_path):
    first = made(tmp_path, nominal_diameters=(1.07,))
    assert first.ran == 3 * 6 and first.kept == 0  # two grids, which are the campaigns on a flat bed too, and the slope
    second = made(tmp_path, height=4.0, nominal_diameters=(0.9, 1.07), probability=0.9)
    assert second.ran == 0 and second.kept == 3 * 6


def test_a_design_that_was_stopped_goes_on(quick, tmp_path, monkeypatch):
    count = []

    def stopped(test):
        count.append(test)
        if len(count) == 8:
            raise KeyboardInterrupt
        return known_run(test)

    monkeypatch.setattr(designs, "result_of", stopped)
    with pytest.raises(KeyboardInterrupt):
        made(tmp_path)
    monkeypatch.setattr(designs, "result_of", known_run)
    again = made(tmp_path)
    with Store(tmp_path / "designs.sqlite") as store:
        assert again.kept == 7 and again.ran + again.kept == len(store)
    assert again.to_dict()["options"] == made(tmp_path).to_dict()["options"]


def test_levels_count_from_the_datum_of_the_bed(quick, tmp_path):
    (tmp_path / "bed.csv").write_text("x_m,y_m,z_m\n" + "".join(f"{x},{y},-4.0\n" for x in (-15, 0, 15) for y in (-15, 0, 15)))
    wanted = {"height": None, "crest": -0.8, "bottom": designs.sea_bottom.parse_bottom("bed.csv", tmp_path)}
    result = made(tmp_path, **wanted)
    row = result.to_dataframe().query("grid == 'TPG' and layers == 3").iloc[0]
    assert row["simulated_height_m"] == pytest.approx(-4.0 + 3.3, abs=0.005)
    assert result.to_dict()["crest_level_m"] == -0.8 and result.to_dict()["height_m"] is None


def test_a_run_that_the_physics_refuses_is_told(tmp_path, monkeypatch):
    monkeypatch.setattr(designs, "result_of", lambda test: {"error": "placement: units overlap; widen the grid"})
    with pytest.raises(
        InputError, match="design: TPG grid of units of 1.068 m, seed 1: placement: units overlap; widen the grid"
    ):
        made(tmp_path)


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ({"height": None}, "either a height above the bed"),
        ({"crest": 1.0}, "either a height above the bed"),
        ({"height": -5.0}, "height = -5.0; it must be a finite number > 0"),
        ({"nominal_diameters": ()}, "no size of unit; give --nominal-diameter"),
        ({"nominal_diameters": (1.0, 0.0)}, "nominal_diameter = 0.0"),
        ({"probability": 1.0}, "probability = 1.0; it must be at least 0.5 and below 1"),
        ({"repeats": 2}, "repeats = 2; must be 5 to 10000"),
        ({"bottom": "hilly"}, "bottom 'hilly': not understood"),
        ({"grids": ("QPG",)}, "give TPG, RPG"),
    ],
)
def test_what_cannot_be_is_refused_by_name(wanted, words):
    with pytest.raises(InputError, match=words):
        Wanted(**{**FLAT, **wanted})


def test_a_height_that_needs_many_layers_is_refused_before_any_run(tmp_path):
    with pytest.raises(InputError, match="20 m may need 23 layers of units of 1 m; at most 12 are tried unasked: take"):
        made(tmp_path, height=20.0)
    with pytest.raises(InputError, match="crest = -1 m is not above the middle of the bed, 0 m"):
        made(tmp_path, height=None, crest=-1.0)


@pytest.mark.parametrize("height", [3.7, 20.0, 50.0, 500.0])
def test_what_is_offered_for_a_height_of_many_layers_is_taken_when_typed(height):
    """The sizes of the message, and its --layers, make tests that can be; no number of layers beyond 50, the most, is offered."""
    with pytest.raises(InputError) as refused:
        Wanted(**FLAT | {"height": height, "nominal_diameters": (0.08 * height**0.5,)}).cases()
    told = str(refused.value)
    sizes, layers = re.findall(r"([\d.]+) m or more", told), re.search(r"--layers (\d+)", told)[1]
    Wanted(**FLAT | {"height": height, "nominal_diameters": (float(sizes[0]),)}).cases()
    last = float(sizes[1]) if len(sizes) > 1 else 0.08 * height**0.5
    assert Wanted(**FLAT | {"height": height, "nominal_diameters": (last,), "layers": int(layers)}).cases()
    assert int(layers) <= 50


def test_a_refused_command_does_not_say_that_it_goes_on(hlcs, tmp_path):
    status, _, errors = hlcs("design", "--height", "50", "--nominal-diameter", "1", "--layers", "58", "--store", "runs.sqlite")
    assert status == 2 and "layers = 58; it must be a whole number from 1 to 50" in errors and "goes on" not in errors


def test_the_command_prints_the_choice_and_writes_its_files(hlcs, quick, tmp_path):
    arguments = [
        "design",
        "--height",
        "5",
        "--nominal-diameter",
        "1.07",
        "--nominal-diameter",
        "1.2",
        "--workers",
        "1",
        "--repeats",
        "6",
    ]
    status, text, _ = hlcs(*arguments, "--store", "runs.sqlite", "--out", "out", "--json", "design.json")
    assert status == 0 and "take 5 layers of units of Dn 1.07 m on the RPG grid" not in text
    data = json.loads((tmp_path / "design.json").read_text())
    row = data["options"][data["chosen"]]
    assert f"take {row['layers']} layers of units of Dn {row['nominal_diameter_m']:g} m on the {row['grid']} grid" in text
    contract = {"grid", "nominal_diameter_m", "spacing_x", "spacing_y", "layers", "height_m", "height_sd_m", "reaches"}
    assert contract | {"concrete_m3_per_m2", "units_per_m2", "lost_share"} <= set(row)
    assert {"format", "height_m", "nominal_diameter_m", "probability", "chosen", "options"} <= set(data)
    names = {path.name for path in (tmp_path / "out").iterdir() if not path.name.startswith(".")}
    assert names == {"design.json", "design.txt", "options.csv", "trade_off.png", "chosen.toml"}
    chosen = read_placement_file(tmp_path / "out" / "chosen.toml")
    assert (chosen.grid.name, chosen.layers) == (row["grid"], row["layers"])
    assert chosen.unit.nominal_diameter == pytest.approx(row["nominal_diameter_m"])
    for words in ("seeds:", "friction: a contact may have 0.36 to 0.6", "model: what it misses the laboratory by", "Table 3"):
        assert words in text


@pytest.mark.parametrize("sizes", [(1.07,), (0.95, 1.0, 1.07), (0.9, 0.95, 1.0, 1.05, 1.07, 1.2)])
def test_names_of_options_hide_nothing_and_what_has_no_name_is_counted(quick, tmp_path, sizes):
    """As drawn, in pixels: no two names overlap, none covers a mark, each is nearest to its own; the chosen one has a name."""
    result = made(tmp_path, nominal_diameters=sizes)
    ax = result.plot()
    ax.figure.draw_without_rendering()
    names = [(name.get_window_extent(), name) for name in ax.texts]
    marks = ax.transData.transform(result.to_dataframe()[["concrete_m3_per_m2", "height_m"]].to_numpy())
    for number, (box, name) in enumerate(names):
        assert ax.bbox.contains(*box.min) and ax.bbox.contains(*box.max)
        assert not box.count_overlaps([other for other, _ in names[:number]])
        gaps = np.linalg.norm(marks - np.clip(marks, box.min, box.max), axis=1)
        assert gaps.min() > 0.0 and np.allclose(marks[gaps.argmin()], ax.transData.transform(name.xy))
    told = f"{len(marks) - len(names)} of {len(marks)} points have no name"
    assert (told in ax.get_xlabel()) == (len(names) < len(marks)) and len(names) >= len(marks) / 2
    chosen = result.options[result.chosen].to_dict()
    assert (chosen["concrete_m3_per_m2"], chosen["height_m"]) in [name.xy for _, name in names]


def test_no_option_is_said_to_be_none(quick, tmp_path):
    result = made(tmp_path, layers=3)
    assert result.chosen is None and "no option reaches it with a probability of 95 %" in result.summary()
    assert "star" in result.plot().get_title() and isinstance(result, Design)


def test_a_ratio_needs_a_run_that_stands():
    with pytest.raises(InputError, match="no run beside 'laboratory, TPG' left a height"):
        model_ratio([(laboratory("table2", grid="TPG"), [None, None])])
    assert ModelRatio(()).campaigns == ()


def test_heights_over_dn_do_not_depend_on_the_size():
    """What one sweep for all sizes rests on: four times as large and all times twice as long, the same digits."""
    small = PlacementTest(layers=2, rows=3, columns=3, seed=3, side=0.25, time_step=1 / 240, settle_time=10.0)
    large = replace(small, side=1.0, time_step=2 / 240, settle_time=20.0)
    np.testing.assert_allclose(small.run().heights, large.run().heights, rtol=1e-9)


def test_a_promised_height_is_the_one_that_is_reached_so_often(generator):
    """Without an effect of friction it is the mean less Student's quantile times the deviation of one more run."""
    friction = np.linspace(0.36, 0.6, 12)
    line = line_through(friction, 5.0 + generator.normal(0.0, 0.1, 12))._replace(slope=0.0)
    promise = design_budget.Promise(line, 1.0)
    for probability in (0.95, 0.5, 0.05):
        assert promise.height_at(probability) == pytest.approx(line.mean - stats.t.ppf(probability, 10) * line.one_more, abs=1e-9)
    assert promise._replace(share=0.5).reaches(line.mean) == pytest.approx(0.25)


def test_a_check_counts_new_runs_beside_the_promise(quick, tmp_path):
    """Seeds and frictions of the 40 runs are new; of 100 throws of a coin 40 to 60 are heads in 95 cases of 100."""
    result = made(tmp_path, height=5.0)
    tests = design_check.new_tests(result, 40)
    assert [test.seed for test in tests] == list(range(7, 47)) and len({test.friction for test in tests}) == 40
    assert all(0.36 < test.friction < 0.6 and test.layers == result.options[result.chosen].layers for test in tests)
    target, *others = design_check.check(result, tmp_path / "designs.sqlite", 40, workers=1)
    assert (target.height, target.runs) == (5.0, 40)
    assert target.promised == pytest.approx(result.options[result.chosen].budget.reaches_simulated)
    assert [each.promised for each in others] == pytest.approx(design_check.PROMISES)
    reached = [each.reached for each in others]
    assert reached == sorted(reached, reverse=True) and reached[0] > 20 > reached[-1]  # the higher, the fewer


def test_counts_of_new_runs_scatter_by_the_binomial_law_and_by_what_few_runs_leave_open():
    """At the mean, 40 to 60 of 100 by the binomial law. Where the scatter s is known well, a mean of n runs is wrong by
    s / sqrt(n): the chance at the mean then has the deviation 0.399 / sqrt(n), and the count that of both together,
    100 sqrt(0.25/100 + 0.159/n)."""
    line = design_budget.Line(mean=5.0, slope=0.0, scatter=0.1, count=1000, middle=0.48)
    half = design_check._reached(5.0, design_budget.Promise(line, 1.0), np.repeat([4.9, 5.1, np.nan], [40, 59, 1]))
    assert (half.reached, half.binomial, half.kept) == (59, (40, 60), True)
    assert (
        "59" in design_check.check_lines([half], "height")[2] and "outside" not in design_check.check_lines([half], "height")[2]
    )
    for count in (200, 1000):
        promise = design_budget.Promise(line._replace(count=count), 1.0)
        wide = 1.96 * 100 * np.sqrt(0.25 / 100 + 0.159 / count)
        low, high = design_check._reached(5.0, promise, np.full(100, 5.1)).expected
        assert (low, high) == (pytest.approx(50 - wide, abs=1.0), pytest.approx(50 + wide, abs=1.0))  # whole units


def test_a_check_of_no_option_is_refused(quick, tmp_path):
    with pytest.raises(InputError, match="none to be checked; leave out --check"):
        design_check.check(made(tmp_path, height=5.0, layers=1), tmp_path / "designs.sqlite", 5)


@pytest.mark.slow
def test_new_runs_reach_the_height_as_often_as_the_simulation_promises(tmp_path, monkeypatch):
    """Two layers of 5 x 5 units, 20 runs; the height one standard deviation below their mean. Then 100 runs of new seeds and
    frictions drawn evenly: how many reach it lies within the binomial interval (99.7 %) of the promise, which itself is known
    only as well as the mean of 20 runs, to two standard errors."""
    monkeypatch.setattr(designs, "CAMPAIGN_REPEATS", 2)
    monkeypatch.setattr(designs, "model_ratio", lambda campaigns: exact_ratio())  # the laboratory has no part in this promise
    store = tmp_path / "designs.sqlite"
    size = {"nominal_diameters": (1.0,), "grids": (TPG,), "layers": 2, "rows": 5, "columns": 5, "probability": 0.5}
    first = designs.design(Wanted(height=2.3, **size), store)
    (promise,) = [option.promise for option in first.options if option.layers == 2]
    deviation = promise.height_at(0.5) - promise.height_at(0.84)
    target, error = promise.height_at(0.84), 2.0 * deviation / np.sqrt(20)
    aimed = designs.design(Wanted(height=target, **size), store)
    assert aimed.ran == 0
    reached = design_check.check(aimed, store, 100)[0]
    print(reached)
    assert reached.runs == 100
    least = stats.binom.ppf(0.0015, 100, promise.reaches(reached.height + error))
    most = stats.binom.ppf(0.9985, 100, promise.reaches(reached.height - error))
    assert least <= reached.reached <= most


@pytest.mark.parametrize(
    ("probability", "shown"), [(1.0, ">99.9"), (0.9994, "99.9"), (0.5, "50.0"), (0.0, "<0.1"), (0.0006, "0.1")]
)
def test_no_number_of_runs_shows_certainty(probability, shown):
    assert chance(probability) == shown
