"""Section 8: formulas as Boolean combinations of leaves, each with one monitor, and the normal form that this needs."""

from reference.temporal import FALSE, TRUE, conjunction, disjunction, is_pi2, is_sigma2, negated, parts


def conditions(f):
    """f as a positive Boolean combination of ("again", g) and ("finally", g): the marks of the monitor of g, a Pi2
    formula, occur again and again, or from some point on never. A conjunction with a U and a disjunction with a W are
    taken apart, since two small monitors have fewer states than one for both."""
    if f[0] in ("and", "or") and any(g[0] == ("U" if f[0] == "and" else "W") for g in parts(f)):
        return (f[0], conditions(f[1]), conditions(f[2]))
    if is_pi2(f):
        return ("again", f)
    if is_sigma2(f):
        return ("finally", negated(f))
    if f[0] == "X" and pushed(f[1]) != f:
        return conditions(pushed(f[1]))
    return conditions(normalised(f))


def pushed(f):
    """X of f, with X pushed below Boolean operators."""
    inner = pushed(f[1]) if f[0] == "X" else f
    return (inner[0], pushed(inner[1]), pushed(inner[2])) if inner[0] in ("and", "or") else ("X", inner)


def cases(condition):
    """The disjunctive normal form of a combination: a list of sets of ("again", g) and ("finally", g)."""
    if condition[0] == "or":
        return cases(condition[1]) + cases(condition[2])
    if condition[0] == "and":
        return [a | b for a in cases(condition[1]) for b in cases(condition[2])]
    return [frozenset([condition])]


# The normal form of Esparza, Rubio and Sickert. Until it is found, `GF p` and `FG p` are formulas of their own.


def normalised(f):
    """An equivalent Boolean combination of formulas in which no U stands below a W, of `GF` of formulas without W, and
    of `FG` of formulas without U."""
    return written_out(taken_apart(without_u_below_w(named_limits(f))))


def built(kind, *inner):
    """A formula, simplified where a part is constant."""
    if kind in ("and", "or"):
        return (conjunction if kind == "and" else disjunction)(*inner)
    if kind in ("X", "GF", "FG"):
        return inner[0] if inner[0] in (TRUE, FALSE) else (kind, inner[0])
    first, second = inner
    if second == TRUE or first == FALSE:
        return second
    if kind == "U":
        return FALSE if second == FALSE else (kind, first, second)
    return TRUE if first == TRUE else (kind, first, second)


def rebuilt(f, change):
    return f if f[0] in ("is", "true", "false") else built(f[0], *map(change, f[1:]))


def with_part(f, old, new):
    """A formula in which another one stands for one of its parts."""
    return new if f == old else rebuilt(f, lambda g: with_part(g, old, new))


def outermost(f, kinds):
    """The first part of a formula of some kinds that stands in no other one; `GF` and `FG` are not entered."""
    if f[0] in kinds:
        return f
    inner = () if f[0] in ("is", "GF", "FG") else f[1:]
    return next(filter(None, (outermost(g, kinds) for g in inner)), None)


def named_limits(f):
    if f[0] == "W" and f[2] == FALSE and f[1][0] == "U" and f[1][1] == TRUE:
        return built("GF", named_limits(f[1][2]))
    if f[0] == "U" and f[1] == TRUE and f[2][0] == "W" and f[2][2] == FALSE:
        return built("FG", named_limits(f[2][1]))
    return rebuilt(f, named_limits)


def without_u_below_w(f):
    """Rules 1 and 2: the outermost W first, and in it an outermost U."""
    if f[0] in ("GF", "FG"):
        return f
    if f[0] != "W" or not any(outermost(g, ("U",)) for g in f[1:]):
        return rebuilt(f, without_u_below_w)
    phi, chi = f[1:]
    if outermost(chi, ("U",)):
        return without_u_below_w(built("or", built("U", phi, chi), built("W", phi, FALSE)))
    until = outermost(phi, ("U",))
    weak = with_part(phi, until, built("W", *until[1:]))
    never = built("W", with_part(phi, until, FALSE), FALSE)
    often = built("and", built("GF", until[2]), built("W", weak, chi))
    return without_u_below_w(built("or", often, built("U", phi, built("or", chi, never))))


def taken_apart(f):
    """Rules 3 to 5: `GF` and `FG` stand below Boolean operators only, `GF` has no W below it, and `FG` no U."""
    if f[0] in ("and", "or"):
        return rebuilt(f, taken_apart)
    if f[0] in ("is", "true", "false"):
        return f
    limit = next(filter(None, (outermost(g, ("GF", "FG")) for g in f[1:])), None)
    if limit:
        there = built("and", limit, with_part(f, limit, TRUE))
        return taken_apart(built("or", there, with_part(f, limit, FALSE)))
    if f[0] == "GF" and outermost(f[1], ("W",)):
        weak = outermost(f[1], ("W",))
        strong = built("GF", with_part(f[1], weak, built("U", *weak[1:])))
        ever = built("and", built("FG", weak[1]), built("GF", with_part(f[1], weak, TRUE)))
        return taken_apart(built("or", strong, ever))
    if f[0] == "FG" and outermost(f[1], ("U",)):
        until = outermost(f[1], ("U",))
        often = built("and", built("GF", until[2]), built("FG", with_part(f[1], until, built("W", *until[1:]))))
        return taken_apart(built("or", often, built("FG", with_part(f[1], until, FALSE))))
    return f


def written_out(f):
    if f[0] == "GF":
        return ("W", ("U", TRUE, f[1]), FALSE)
    if f[0] == "FG":
        return ("U", TRUE, ("W", f[1], FALSE))
    return rebuilt(f, written_out)
