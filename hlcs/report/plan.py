"""How a Plan is shown: printed."""

from hlcs.report.words import note_lines, number


def text(plan):
    """The printed report of a Plan."""
    numbers = ", ".join(f"{name} = {value:g}" for name, value in plan.at.items())
    many, count = plan.what, plan.now["recordings"]
    lines = [
        f"Plan: {plan.effect}, {numbers}, to be found with probability {plan.power:g}",
        "",
        f"Pilot: {count} {many}, noncentrality {plan.noncentrality:.3g}, power {plan.now['power']:.2f}",
        "",
        f"  {'':16s} {'length':>9s} {'sigma':>12s} {'needed':>7s}  noncentrality, each  power of {count}",
    ]
    for row in plan.options:
        needed = _needed(row["recordings"])
        lines.append(
            f"  {row['change']:16s} {number(row['length_s'], 's'):>9s} {number(row['sigma'], row['unit']):>12s} {needed:>7s}  "
            f"{row['noncentrality']:19.3g}  {row['power']:{len(f'power of {count}')}.2f}"
        )
    lines += ["", _advice(plan)]
    lines += _look_alike_lines(plan)
    return "\n".join(lines + note_lines(plan.notes))


def _advice(plan):
    """What to do, in a sentence."""
    if plan.needed["recordings"] is not None:
        length = plan.needed["length_s"]
        each = "" if length is None else f" of {length:.3g} s"
        sigma = number(plan.needed["sigma"], plan.needed["unit"])
        return f"Needed: {plan.needed['recordings']} {plan.what}{each}, with a noise of {sigma}."
    others = [row for row in plan.options[1:] if row["recordings"] is not None]
    told = "; or ".join(f"{row['change']}: {row['recordings']}, noise {number(row['sigma'], row['unit'])}" for row in others)
    return f"Infeasible: more than 1,000 {plan.what} like these. " + (f"Instead: {told}." if told else "Change the experiment.")


def _look_alike_lines(plan):
    """Which look-alikes finding the effect would leave open, and what tells the others from it."""
    needed, left_open, apart = plan.needed["recordings"], [], []
    for other in plan.look_alikes:
        count = other["recordings"]
        if count is None or needed is None or count > needed:
            left_open.append(f"{other['effect']} ({'over 100' if count is None else count} tell them apart)")
        else:
            apart.append(other["effect"])
    lines = [f"Finding it would leave open, in experiments like these: {', '.join(left_open)}"] if left_open else []
    lines += [f"Alike, but told apart by as many: {', '.join(apart)}"] if apart else []
    return ["", *lines] if lines else []


def _needed(count):
    return "> 1000" if count is None else str(count)
