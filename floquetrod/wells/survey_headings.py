"""Headings of the columns of a survey, as vendors and offices of several countries write them."""

from __future__ import annotations

import functools
import re
import unicodedata
from collections.abc import Sequence

from floquetrod import units
from floquetrod.tables.head import best

KINDS = {"depth": "length", "inclination": "angle", "azimuth": "angle"}
"""The columns of a survey by directions, each with its kind of quantity."""

AXES = {"depth": "length", "north": "length", "east": "length", "down": "length"}
"""The columns of a survey by positions."""

WELL_LABELS = (
    "well",
    "wellbore",
    "well name",
    "well id",
    "uwi",
    "hole",
    "hole id",
    "bhid",
    "borehole",
    "sidetrack",
    "api",
)
"""Headings of columns that name the well."""


def _vocabulary(text: str) -> frozenset[str]:
    return frozenset(_plain(text).split())


_LETTERS = str.maketrans({"ø": "o", "æ": "ae", "ł": "l", "đ": "d", "ı": "i", "œ": "oe"})
_BRACKETS = re.compile(r"[\[({]\s*([^\[\](){}]*?)\s*[\])}]")
_LAST = re.compile(r"(.*[^\s_,;/:.-])\s*[\s_,;/:-]\s*([^\s_,;/:]+)")


def _plain(text: str) -> str:
    """Return small letters without accents."""
    folded = unicodedata.normalize("NFKD", text.casefold().translate(_LETTERS))
    return "".join(letter for letter in folded if not unicodedata.combining(letter))


# Words of each language: English; Spanish, Portuguese, Italian; French; German, Dutch; Norwegian, Danish, Swedish;
# Russian, Ukrainian; Polish; Turkish; Indonesian; Romanian; Chinese.
_MEASURED = _vocabulary(
    "md mdepth measured measure meas measd msd mdepth mdkb mdrkb mdrt mdbrt mddf mdgl mdrte mdbdf mdft mdm ah ahd "
    "ahdrt ahbdf ahbrt ahort along alonghole drillers driller drilled medida medido med desarrollada desarrollado "
    "pm misurata misurato mes mesuree mesure foree developpee gemessene gemessen gemessener gem messtiefe "
    "messteufe bohrteufe bohrtiefe bohrlochtiefe bohrlochteufe bohrlochlange bohrlange gemeten malt maltdyp "
    "maltdybde matt mitattu измеренная измер изм замера замер стволу ствола ствол забой забоя вимiряна стовбуру "
    "mierzona mierz zmierzona olculen terukur masurata merena mert smd mwdmd mmd log logging wireline cable tot "
    "total bohrmeter dmea surveymd measdepth measureddepth tmd"
)
_DEPTH = _vocabulary(
    "depth depths dept dep dpth dpt dph tdep profundidad prof profundidade profondeur profondita cote teufe tiefe "
    "diepte dyp dybde djup dyb dyp syvyys глубина глуб гл глибина glebokosc gleb derinlik kedalaman adancime "
    "hloubka melyseg depthmd mdepth distance lengde longueur lange laenge lengte длина"
)
_LENGTHS = _vocabulary("distance lengde longueur lange laenge lengte длина")  # depths beside a word for measured
_ADJECTIVES = _vocabulary("drilled med mes along log logging wireline cable tot total")  # which need a word for depth
_CHINESE = {"depth": ("测深", "井深", "斜深", "測深"), "inclination": ("井斜", "斜角"), "azimuth": ("方位",)}

_INCLINED = _vocabulary(
    "inc incl inclin incln inclination inclinations incli inca sinc sincl mwdinc gyroinc devi deviated hdev "
    "inclinacion inclinacao inclinazione inclinaison inclinado neigung neigungswinkel inklination inkl inklin "
    "neig inclinatie inklinasjon helning hellning haeldning haldning hullvinkel lutning kaltevuus зенит зенитный "
    "зен зенитныи наклон наклона инклинация нахил inklinacja inklinacji nachylenie egim inklinasi kemiringan "
    "inclinare inclinatie sklon slant tilt zen inklinasjonsvinkel zenith zenit zenitwinkel zenital inklinace "
    "ferdeseg driftangle holeangle holeinc"
)
_DEVIATED = _vocabulary(
    "drift dev deviation devn deviacion desviacion desv desvio deviazione deviation abweichung afwijking avvik "
    "odchylenie sapma deviatie helling hoek"
)
_ANGLE = _vocabulary(
    "angle ang angles angulo angolo winkel vinkel hoek угол кут kat acisi aci sudut unghi uhel szog vertical vert "
    "zavrtu"
)
_AZIMUTHAL = _vocabulary(
    "azi azim azimuth azimuths az azm azmth azmuth azimuthal azith azmt haz hazi hazim saz azn sazi sazm sazc "
    "azgn aztn azimut acimut azimute azimutwinkel azimutal asimut atsimuuttikulma asimuth azymut azimutus azimuti "
    "азимут аз азм дирекционныи дирекц дир mwdazi gyroazi gridazi trueazi magazi azigrid azitrue azimag azigeo "
    "azicorr azin azt azg"
)
_DIRECTION = _vocabulary(
    "direction dir dirn drctn bearing brg heading hdg rumbo direccion direcao direzione richtung retning riktning "
    "kurs compass richting suunta направление kierunek yon arah directie smer irany cap"
)
_SIDES = _vocabulary(
    "grid true mag magnetic magn magnetico magnetique magnetisch north gn tn mn geographic geo geog utm rete nord "
    "norte noord nord vrai geographique grille wahr rechtweisend missweisend verdadero verdadera geografico "
    "cuadricula истинныи ист магнитныи маг магн географическии геогр verdadeiro verdadeira n"
)
_DATUM = _vocabulary("kb rkb rt brt rte df bdf gl rotary table kelly bushing below from surface datum relative to")
_ASIDE = _vocabulary(
    "hole well wellbore borehole bore survey surveys surv svy srvy sur station stations stn sta stat of the at in "
    "de del da do du d la le der des dem corr corrected cor raw final actual act obs observed calc calculated mwd "
    "gyro lwd ems ess static cont continuous measured meas definitive gms pozo poco puits forage brunnen bohrloch "
    "hull bronn brenn скв скважины по скважина замера кривизны искривления otworu value val reading в от kuyu "
    "sumur sondy"
)


def words_of(text: str) -> tuple[str, ...]:
    """Return the words of a heading in small letters without accents.

    >>> words_of("MeasuredDepth_MD"), words_of("Prof. Medida"), words_of("Azi(GN)")
    (('measured', 'depth', 'md'), ('prof', 'medida'), ('azi', 'gn'))
    """
    apart = re.sub(r"(?<=[a-zà-ÿ])(?=[A-ZÀ-Þ])", " ", text)
    apart = re.sub(r"\b([A-Za-z])\.\s?([A-Za-z])\.?(?=\W|$)", r"\1\2", apart)  # M.D.
    return tuple(re.findall(r"[^\W_]+", _plain(apart.replace("'", ""))))


@functools.lru_cache(maxsize=4096)
def parts(heading: str, kind: str) -> tuple[str, str | None]:
    """Return name and unit of a heading, None without a unit; brackets may hold words, such as a datum, instead.

    >>> parts("MD (m RKB)", "length"), parts("Depth (MD), ft", "length"), parts("Azi (deg Grid)", "angle")
    (('MD', 'm RKB'), ('Depth MD', 'ft'), ('Azi Grid', 'deg'))
    """
    text, unit = heading.strip(), None
    for match in reversed(list(_BRACKETS.finditer(text))):
        within = match[1].strip()
        named = _unit_of(within, kind)
        known = named is not None or not _is_of_words(within)
        if known and unit is None:
            unit, rest = named if named is not None else (within, "")
            within = rest
        text = f"{text[: match.start()]} {within} {text[match.end() :]}"
    text = re.sub(r"\s+", " ", text).strip()
    if unit is None and _is_unit(text, kind):
        return "", text
    if unit is None and (last := _LAST.fullmatch(text)) and _is_unit(last[2], kind):
        text, unit = last[1], last[2]
    head, comma, rest = text.partition(",")
    if unit is None and comma and (named := _unit_of(rest.strip(), kind)) is not None:
        text, unit = f"{head} {named[1]}", named[0]
    return text.strip(" ,;/:-"), None if unit is None else in_english(unit)


_UNITS = {
    "m": "metros metri м метр метры метров metrow metr metru metrou meters",
    "ft": "pies pieds pes fot fuss фут футы ft. ft' '",
    "deg": "grados graus degres gradi grader град градус градусы градусах stopnie stopni derece derajat deg. degs dega",
}
"""Names of units in other languages than those of `floquetrod.units`; neither Grad nor grades, which may be gon."""

_UNIT = {word: unit for unit, names in _UNITS.items() for word in names.split()}


def in_english(unit: str) -> str:
    """Return a unit by its English name where it is one of `_UNITS`, else as written."""
    return _UNIT.get(_plain(unit.strip()), unit.strip())


def _is_unit(word: str, kind: str) -> bool:
    return units.is_unit(in_english(word), kind)


def _unit_of(text: str, kind: str) -> tuple[str, str] | None:
    """Return the unit that begins a text, and the words after it; None for another text."""
    if _is_unit(text, kind):
        return text, ""
    first, _, rest = text.partition(" ")
    first = first.rstrip(",;")
    if rest and _is_unit(first, kind) and _is_of_words(rest):
        return first, rest
    return None


def _is_of_words(text: str) -> bool:
    """Return whether a text has words of headings alone."""
    known = _SIDES | _DATUM | _ASIDE | _MEASURED | _DEPTH | _AZIMUTHAL | _INCLINED | _ANGLE | _VERTICAL
    return bool(words_of(text)) and all(word in known for word in words_of(text))


_VERTICAL = _vocabulary("tvd tvdss ss subsea vertical vert verticale msl")


def rank(name: str, heading: str) -> int | None:
    """Return how well a heading suits a column, the best 0; None where it is of another quantity.

    >>> [rank("depth", text) for text in ("Meas. Depth (ft)", "Survey Depth", "Depth", "True Vertical Depth", "TVD")]
    [0, 1, 2, None, None]
    >>> rank("inclination", "Drift Angle"), rank("azimuth", "Drift Direction"), rank("inclination", "Build Rate")
    (1, 1, None)
    """
    words = words_of(parts(heading, KINDS[name])[0])
    if any(term in "".join(words) for term in _CHINESE[name]) and "垂" not in heading:
        return 0
    if not words:
        return None
    return {"depth": _rank_of_depth, "inclination": _rank_of_inclination, "azimuth": _rank_of_azimuth}[name](words)


def _rank_of_depth(words: Sequence[str]) -> int | None:
    if "m" in words and set(words) & _DEPTH:  # M Depth
        words = [word if word != "m" else "md" for word in words]
    if not set(words) <= _MEASURED | _DEPTH | _DATUM | _ASIDE:
        return None
    main = set(words) - _DATUM - (_ASIDE - _MEASURED)
    if main & _MEASURED:
        return 0 if main & _MEASURED - _ADJECTIVES or main & _DEPTH else None
    if not main & _DEPTH - _LENGTHS:
        return None
    if {"hole", "bore"} & set(words):
        return 3
    return 1 if set(words) & _ASIDE else 2


def _rank_of_inclination(words: Sequence[str]) -> int | None:
    named = set(words) - _ASIDE
    if not named or not named <= _INCLINED | _DEVIATED | _ANGLE | _vocabulary("from"):
        return None
    if named & _INCLINED:
        return 0
    if named & _DEVIATED:
        return 1
    return 2 if named - {"vertical", "vert"} else None


def _rank_of_azimuth(words: Sequence[str]) -> int | None:
    named = set(words) - _ASIDE - _SIDES - {"to", "from", "relative"}
    if not named or not named <= _AZIMUTHAL | _DIRECTION | _DEVIATED | _INCLINED | _ANGLE:
        return None
    if named & _AZIMUTHAL:
        return 0
    return 1 if named & _DIRECTION else None


def places_of(name: str, headings: Sequence[str]) -> list[int]:
    """Return the places of the headings that suit a column best; of two depths the one next to an inclination.

    Azimuths are all those that there are, to true, grid or magnetic north: which of them is meant is a choice.
    """
    if name == "azimuth":
        ranks = {i: value for i, text in enumerate(headings) if (value := rank(name, text)) is not None}
        sure = [i for i, value in ranks.items() if value == 0]
        return sure or list(ranks)
    places = best(headings, lambda text: rank(name, text))
    if name == "depth" and len(places) > 1:
        beside = {i for i, text in enumerate(headings) if rank("inclination", text) is not None}
        close = [i for i in places if i + 1 in beside]
        return close if len(close) == 1 else places
    return places


_OF_AXES = {
    "north": _vocabulary("n north northing northings nord norte y ns dispns norden nordwert ycoord noord север"),
    "east": _vocabulary("e east easting eastings est este x ew dispew ost ostwert xcoord oost leste восток"),
    "down": _vocabulary(
        "tvd z tvdss tvdmsl tvdkb tvdrkb tvdrt vertical vert true depth elevation elev zcoord subsea ss msl"
    ),
}
_BESIDE_AXES = _vocabulary(
    "s w local grid map utm offset coordinate coord coordinates departure displacement m ft world"
)


def rank_of_axis(name: str, heading: str) -> int | None:
    """Return how well a heading suits a column of positions; None where it is of another quantity.

    >>> rank_of_axis("north", "+N/-S (ft)"), rank_of_axis("east", "Easting"), rank_of_axis("down", "TVD [m]")
    (0, 0, 0)
    """
    if name == "depth":
        suits = rank(name, heading)
        return suits if suits == 0 else None
    words = set(words_of(parts(heading, AXES[name])[0]))
    own = words & _OF_AXES[name] - ({"true", "depth"} if name == "down" else set())
    if name == "down" and words <= {"true", "depth"}:
        return None
    return 0 if own and words <= _OF_AXES[name] | _BESIDE_AXES | _DATUM else None


def places_of_axis(name: str, headings: Sequence[str]) -> list[int]:
    """Return the places of the headings that suit a column of positions."""
    return best(headings, lambda text: rank_of_axis(name, text))
