"""Headings of surveys as vendors and offices of several countries write them: which column each is, and its unit."""

from __future__ import annotations

import pytest

from floquetrod.wells.survey_headings import KINDS, parts, rank, rank_of_axis

HEADINGS = {
    "depth": "MD|MD (m)|M.D.|MDRKB|MD RKB|MDRT|MD BRT (m)|MDKB|MD (m RKB)|Meas. Depth|Measured Depth|"
    "MEASURED DEPTH (ft)|MeasuredDepth|Measured|Survey MD|"
    "Survey Depth|Svy Depth|Station Depth|Depth MD|Depth (MD)|DEPT|DEPTH|Depth, m|"
    "Along Hole Depth|AHD|Driller's Depth|Hole Depth|DMEA|M Depth|Measured Depth RKB|Wireline Depth|"
    "Profundidad Medida|Prof. Med.|PM|Profundidade Medida|Profondeur mesurée|Prof. MD|Meßtiefe|Gemessene Teufe|Teufe|"
    "Глубина|Глубина по стволу|Глубина замера, м|Målt dyp|Dybde|Mätt djup|Głębokość|Gemeten diepte|测深",
    "inclination": "INC|Incl.|Inclination|Inclin.|Hole Inc|Hole Angle|Hole Deviation|Drift|Drift Angle|Dev|DEVI|"
    "Deviation Angle|Angle|Inc Angle|Angle of Inclination|Survey Inc|Wellbore Incl|MWD Inc|SINC|Inclinación|Ángulo|"
    "Desviación|Inclinação|Inclinaison|Déviation|Neigung|Neigungswinkel|Helning|Inklinasjon|Зенитный угол|"
    "Зен. угол, град|Угол наклона|Zenith Angle|Incl. from Vertical|井斜角",
    "azimuth": "AZI|Azim.|Azimuth|AZM|Grid Azi|Grid Azimuth|Azimuth Grid|AZIM_GN|AZIM_TN|True Azimuth|Azimuth (True)|"
    "Mag Azimuth|Corr. Azimuth|Hole Azimuth|Hole Direction|Direction|HAZI|Survey Azi|Bearing|Drift Direction|"
    "Azimuth TN (deg)|Azi (deg Grid)|Azimuth from Grid North|Azimut|Acimut|Rumbo|Dirección|Azimute|Direção|"
    "Azimut géographique|Richtung|Asimut|Retning|Азимут|Азимут магн.|Дирекционный угол|方位角",
}
OTHERS = (
    "TVD|True Vertical Depth|Vertical Depth|TVDSS|Sub-Sea Depth|Vert. Section|Vertical Section|DLS|Dogleg|Build Rate|"
    "Turn Rate|Walk Rate|Course Length|Closure|Closure Azimuth|Closure Direction|Toolface|Bit Depth|Casing Depth|N/S|"
    "Northing|Station|No|Inc Error|Azi sigma|Delta Inc|Azimuth change|Profundidad Vertical|Vertikalteufe|Dip|Mag Dip|"
    "Глубина по вертикали|Magnetic Declination|Grid convergence|Vertical Section Azimuth|Target Azimuth|Comments|Type"
)


@pytest.mark.parametrize("name", KINDS)
def test_headings_of_vendors_are_understood_as_one_column(name: str) -> None:
    for heading in HEADINGS[name].split("|"):
        assert [other for other in KINDS if rank(other, heading) is not None] == [name], heading


def test_other_columns_of_a_survey_are_none_of_its_directions() -> None:
    for heading in OTHERS.split("|"):
        assert [name for name in KINDS if rank(name, heading) is not None] == [], heading


@pytest.mark.parametrize(
    ("heading", "kind", "unit"),
    [
        ("MD (m RKB)", "length", "m RKB"),
        ("MD, ft", "length", "ft"),
        ("Depth (ft) KB", "length", "ft"),
        ("Глубина, м", "length", "m"),
        ("Profundidad (pies)", "length", "ft"),
        ("MD (chain)", "length", "chain"),
        ("Depth (MD)", "length", None),
        ("Azi (deg Grid)", "angle", "deg"),
        ("Азимут, град", "angle", "deg"),
        ("Azimuth (True)", "angle", None),
        ("Inc (mil)", "angle", "mil"),
        ("Inclination [°]", "angle", "°"),
    ],
)
def test_units_in_headings_stand_beside_a_datum_or_a_north(heading: str, kind: str, unit: str | None) -> None:
    assert parts(heading, kind)[1] == unit


def test_positions_are_known_by_their_headings() -> None:
    headings = {
        "north": "+N/-S (ft)|Northing|Y|North",
        "east": "+E/-W|Easting|X",
        "down": "TVD [m]|Z|TVDSS",
        "depth": "MD",
    }
    for name, texts in headings.items():
        for text in texts.split("|"):
            assert [axis for axis in headings if rank_of_axis(axis, text) is not None] == [name], text
