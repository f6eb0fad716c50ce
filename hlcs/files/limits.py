"""What numbers of settings usually are, and how much work is taken on."""

LARGEST = 1e12  # no quantity of a laboratory is larger in SI units, and its cube is still a number
# Numbers that can be computed with but are hardly meant outside of these: lowest, highest, unit, why.
USUAL = {
    "side": (5e-3, 10.0, "m", "models have sides of centimetres, the largest armour units of 4 m: lengths are in m"),
    "radius": (1e-4, 10.0, "m", "shot and grains have a radius of a millimetre, boulders of some metres: lengths are in m"),
    "mass": (1e-6, 1e5, "kg", "a grain of sand has 1e-6 kg, the largest armour units 150 t: masses are in kg"),
    "density": (500.0, 12000.0, "kg/m3", "wood has 500, concrete 2400, lead 11300: 2.4 t/m3 are 2400 kg/m3"),
    "friction": (0.0, 2.0, "1", "rubber on concrete has 1.2: of an angle write the tangent, 0.6 for 31 degrees"),
    "gravity": (0.0, 25.0, "m/s2", "Jupiter has 24.8, the Earth 9.81: lengths are in m, not in feet or cm"),
    "fluid_density": (0.05, 14000.0, "kg/m3", "air has 1.2, water 1000, mercury 13600, a vacuum 0: not in g/cm3"),
    "fluid_viscosity": (0.0, 100.0, "Pa s", "water has 0.001, honey 10"),
    "tube_radius": (1e-3, 2.0, "m", "a measuring cylinder has 0.03, a water tower some metres: half the inner diameter, in m"),
    "falling_distance": (0.0, 5.0, "Dn", "units are let go at 0.25 Dn: a distance in nominal diameters, not in m or cm"),
    "position": (1e-7, 0.2, "m", "trackers are good to some millimetres, 0.002 m: a noise is in m, not in mm"),
    "orientation": (1e-6, 0.5, "rad", "trackers are good to a degree, 0.02 rad: a noise is in rad, not in degrees"),
    "slope": (-1.0, 1.0, "1", "a rise over its run, 0.087 for 5 degrees, 0.05 for 5 %: degrees stand in the column angle_deg"),
    "height_m": (0.0, 60.0, "m", "a stairwell has 10, a tower 50: heights are in m, not in cm"),
    "settle_time": (0.1, 600.0, "s", "a layer comes to rest within some seconds"),
}
NOTHING = ("fluid_density",)  # of which zero says that there is none
MOST_STEPS = 10_000_000  # of a layer, or of all recordings: a step of the smallest test takes 0.4 ms, so an hour at the least


def unlikely(name, value):
    """What is odd about a number of that name, in words; "" where nothing is."""
    if name not in USUAL:
        return ""
    low, high, unit, why = USUAL[name]
    unit = "" if unit == "1" else f" {unit}"
    if value == 0 and name in NOTHING:
        return ""
    return "" if low <= value <= high else f"{value:g}{unit} is hardly meant; usual is {low:g} to {high:g}: {why}"
