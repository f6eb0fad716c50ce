"""How a Design is shown and saved: in plain words, as a table, as a picture of height against concrete, as files."""

import html as markup
from dataclasses import replace
from pathlib import Path

from hlcs.files import folders
from hlcs.files.spreadsheets import as_columns, csv_text
from hlcs.placement import design_figures, figures
from hlcs.placement.design_budget import FRICTIONS
from hlcs.placement.number_text import chance, or_dash, percent
from hlcs.placement.sea_bottom import Survey
from hlcs.placement.settings_table import SURVEY_FILE, bottom_words, placement_table

PARTS = {  # of the variance, in words
    "seeds": "seeds: how runs of one friction differ",
    "friction": f"friction: a contact may have {FRICTIONS[0]:g} to {FRICTIONS[1]:g}",
    "model": "model: what it misses the laboratory by",
}


def line(design):
    """The design in a line: what to take."""
    return headline(design)


def text(design):
    """The report: what to take, the options, what the uncertainty is made of."""
    lines = [headline(design), "", *table(design), ""]
    for option in design.options[slice(0, 1) if design.chosen is None else slice(design.chosen, design.chosen + 1)]:
        lines += [*uncertainty(option), ""]
    lines += model_lines(design.ratio)
    lines.append(f"{design.ran + design.kept} runs, {design.ran} now, {design.kept} found in the store")
    return "\n".join([*lines, design.told] if design.told else lines)


def asked(design):
    """What was asked for, in words."""
    wanted = design.wanted
    bed = "a surveyed bed" if isinstance(wanted.bottom, Survey) else f"a bed that is {bottom_words(wanted.bottom)}"
    what = f"{wanted.height:g} m above" if wanted.crest is None else f"a crest at {wanted.crest:g} m above datum on"
    return f"{what} {bed}"


def headline(design):
    """What to take, in a sentence or two."""
    if not design.options:
        return f"{asked(design)}: no option"
    probability = f"{100 * design.wanted.probability:g} %"
    if design.chosen is None:
        best = max(design.options, key=lambda option: option.budget.reaches)
        return (
            f"{asked(design)}: no option reaches it with a probability of {probability}. The surest one is {named(best)}, with "
            f"{chance(best.budget.reaches)} %. Add a layer (--layers), or take larger units."
        )
    option = design.options[design.chosen]
    row = option.to_dict()
    return (
        f"{asked(design)}: take {named(option)}. It reaches that with a probability of {chance(row['reaches'])} %, and "
        f"needs {row['concrete_m3_per_m2']:.3g} m3 of concrete per m2 of plan, {row['units_per_m2']:.3g} units per m2; "
        f"{percent(row['lost_share'], '.1f')} % of the units fell out of their layer."
    )


def named(option):
    """An option in words."""
    return f"{option.layers} layers of units of Dn {option.nominal_diameter:g} m on the {option.grid.name} grid"


def table(design):
    """The options, one line each, least concrete first; the chosen one is marked."""
    level = "height" if design.wanted.crest is None else "level"
    sure = f"{100 * design.wanted.probability:g} % reach"
    lines = [
        f"  grid            layers   Dn m  {level:>7} m    sd m  {sure:>11} m    P %  simulated P %  m3/m2  units/m2  lost %"
    ]
    for number, option in enumerate(design.options):
        row, mark = option.to_dict(), ">" if number == design.chosen else " "
        cells = [
            f"{mark} {row['grid']:<15} {row['layers']:6d}  {row['nominal_diameter_m']:5.3g}",
            f"{or_dash(row['height_m'], '.3f'):>9}  {or_dash(row['height_sd_m'], '.3f'):>6}",
            f"{or_dash(row['height_at_probability_m'], '.3f'):>13}  {chance(row['reaches']):>5}",
            f"{chance(row['reaches_simulated']):>13}  {row['concrete_m3_per_m2']:5.3g}  {row['units_per_m2']:8.3g}",
            f"{percent(row['lost_share'], '.1f'):>6}",
        ]
        lines.append("  ".join(cells))
    fallen = [option for option in design.options if option.budget.standing_share < 1.0]
    return lines + [
        f"  {named(option)}: {percent(1.0 - option.budget.standing_share, '.0f')} % of {option.runs} runs left no top that could "
        "be measured; its P counts them as not reaching"
        for option in fallen
    ]


def uncertainty(option):
    """What the height of an option is uncertain by."""
    budget = option.budget
    lines = [f"What {named(option)} is uncertain by: {or_dash(budget.height_sd_m, '.3f')} m (one standard deviation)"]
    return lines + [
        f"  {percent(share, '.0f'):>3} % of the variance  {PARTS[part]}" for part, share in budget.variance_shares.items()
    ]


def model_lines(ratio):
    """The laboratory's heights beside the model's."""
    lines = [
        f"The model's own error: the laboratory's heights are {ratio.mean:.4f} +- {ratio.deviation:.4f} of the model's "
        f"({len(ratio.campaigns)} campaigns); heights and P are corrected by that, simulated P is not"
    ]
    return lines + [
        f"  {campaign.measured / campaign.model:.4f}  {campaign.title}: {campaign.measured:.3f} Dn measured, "
        f"{campaign.model:.3f} Dn in {campaign.runs} runs; {campaign.source}"
        for campaign in ratio.campaigns
    ]


def html(design):
    """A design in a notebook."""
    return f"<p>{markup.escape(headline(design))}</p>" + design.to_dataframe().to_html(index=False)


def plot(design, ax=None):
    """Height against concrete; returns the Axes."""
    return design_figures.trade_off_axes(design, ax)


def save(design, folder):
    """Write options.csv, design.json, design.txt, trade_off.png and, where an option is chosen, chosen.toml (with its bed)."""
    with folders.result_folder(folder) as partial:
        write(design, partial)
    return Path(folder)


def write(design, folder):
    """All files of a design into an existing, empty folder; elsewhere where that fails, see `folders.keep`."""
    document = folders.to_json(design.to_dict())
    rows = [
        {key: value for key, value in row.items() if key != "variance_shares"}
        | {f"variance_share_{part}": share for part, share in row["variance_shares"].items()}
        for row in (option.to_dict() for option in design.options)
    ]

    def write_into(place):
        folders.write_text(place / "design.json", document)
        folders.write_text(place / "design.txt", text(design) + "\n")
        folders.write_text(place / "options.csv", csv_text(as_columns(rows)))
        folders.write_bytes(place / "trade_off.png", figures.png_bytes(plot(design).figure))
        if design.chosen is not None:
            chosen = replace(design.options[design.chosen].test, seed=design.wanted.seed)
            folders.write_toml(place / "chosen.toml", {"placement": placement_table(chosen)})
            if bottom_words(chosen.bottom) == SURVEY_FILE:
                folders.write_text(place / SURVEY_FILE, chosen.bottom.csv_text())

    folders.keep(write_into, folder, document)
