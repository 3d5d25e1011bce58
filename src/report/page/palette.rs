//! Colours that everyone can distinguish, on screens and in print.

use meliora_planning::Rank;

/// A colour: red, green, blue.
pub(super) type Rgb = [u8; 3];

/// Colours for one to five improvements: green to blue, after ColorBrewer's YlGnBu, which grows
/// darker step by step and is also readable in grey. A number has the same colour in every picture.
const LADDER: [Rgb; 5] = [[190, 230, 200], [46, 152, 184], [34, 112, 176], [36, 74, 150], [44, 45, 125]];
/// The colour for no improvement, and for the class `nothing`.
pub(super) const NONE: Rgb = [243, 241, 233];
/// The colour of unsafe states.
pub(super) const UNSAFE: Rgb = [242, 191, 178];
/// The colour for any number of improvements.
const UNBOUNDED: Rgb = [8, 18, 66];
/// The colours of classes, from Okabe and Ito, which people with any colour vision can distinguish.
const CLASSES: [Rgb; 8] = [
    [230, 159, 0],
    [86, 180, 233],
    [0, 158, 115],
    [240, 228, 66],
    [0, 114, 178],
    [213, 94, 0],
    [204, 121, 167],
    [140, 140, 140],
];

/// Returns the colour of a rank; `most` is the greatest finite one.
pub(super) fn rank(rank: Rank, most: usize) -> Rgb {
    let (last, deepest) = (LADDER.len(), LADDER[LADDER.len() - 1]);
    match rank {
        Rank::Unbounded => UNBOUNDED,
        Rank::Finite(0) | Rank::AtLeast(0) => NONE,
        Rank::Finite(k) | Rank::AtLeast(k) if k <= last => LADDER[k - 1],
        Rank::Finite(k) | Rank::AtLeast(k) => {
            let steps = most.max(k) - last + 1;
            mix(deepest, UNBOUNDED, (k - last) as f64 / steps as f64)
        }
    }
}

/// Returns the colour of a share between 0 and 1: larger shares are darker.
pub(super) fn scale(share: f64) -> Rgb {
    let place = share.clamp(0.0, 1.0) * (LADDER.len() - 1) as f64;
    let below = (place as usize).min(LADDER.len() - 2);
    mix(LADDER[below], LADDER[below + 1], place - below as f64)
}

/// Returns the colour of a share and the colour of texts on it, as values of CSS, which follow the theme of
/// the page.
pub(super) fn scaled(share: f64) -> (String, &'static str) {
    let place = share.clamp(0.0, 1.0) * (LADDER.len() - 1) as f64;
    let below = (place as usize).min(LADDER.len() - 2);
    let (from, to, percent) = (LADDER[below], LADDER[below + 1], 100.0 * (place - below as f64));
    match percent {
        0.0 => (css(from), ink(from)),
        100.0 => (css(to), ink(to)),
        p => {
            let ink = if is_dark(scale(share)) { ink(to) } else { ink(from) };
            (format!("color-mix(in srgb, {}, {} {p:.0}%)", css(from), css(to)), ink)
        }
    }
}

/// Returns a colour as a value of CSS. The colours of numbers follow the theme of the page: more
/// improvements are darker in the light theme, and lighter in the dark one.
pub(super) fn css(color: Rgb) -> String {
    match name(color) {
        Some((name, _)) => format!("var(--{name}, {})", hex(color)),
        None => hex(color),
    }
}

/// Returns the variable of CSS that a colour has, and the value for texts on it.
fn name(color: Rgb) -> Option<(&'static str, &'static str)> {
    const NAMES: [(&str, &str); 5] = [
        ("one", "var(--one-ink, #1a1a1a)"),
        ("two", "var(--two-ink, #ffffff)"),
        ("three", "var(--three-ink, #ffffff)"),
        ("four", "var(--four-ink, #ffffff)"),
        ("five", "var(--five-ink, #ffffff)"),
    ];
    match color {
        NONE => Some(("none", "var(--none-ink, #6b685e)")),
        UNBOUNDED => Some(("any", "var(--any-ink, #ffffff)")),
        _ => LADDER.iter().position(|&known| known == color).map(|step| NAMES[step]),
    }
}

/// Returns the colour of a class by its position; `None` stands for the class `nothing`.
pub(super) fn class(position: Option<usize>) -> Rgb {
    let Some(position) = position else { return NONE };
    let base = CLASSES[position % CLASSES.len()];
    // With more classes than colours, the colours repeat, first darker and then paler.
    match position / CLASSES.len() {
        0 => base,
        1 => mix(base, [0, 0, 0], 0.45),
        _ => mix(base, [255, 255, 255], 0.55),
    }
}

fn mix(from: Rgb, to: Rgb, share: f64) -> Rgb {
    let one = |i: usize| (f64::from(from[i]) * (1.0 - share) + f64::from(to[i]) * share).round() as u8;
    [one(0), one(1), one(2)]
}

/// Returns black or white, whichever is more readable on a colour.
pub(super) fn ink(on: Rgb) -> &'static str {
    match name(on) {
        Some((_, ink)) => ink,
        None if is_dark(on) => "#ffffff",
        None => "#1a1a1a",
    }
}

fn is_dark(color: Rgb) -> bool {
    let [r, g, b] = color.map(f64::from);
    0.299 * r + 0.587 * g + 0.114 * b <= 140.0
}

/// `#rrggbb`
pub(super) fn hex([r, g, b]: Rgb) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_colours_of_the_scale_follow_the_theme() {
        let (light, one) = ("var(--one, #bee6c8)", "var(--one-ink, #1a1a1a)");
        assert_eq!(scaled(0.0), (light.to_owned(), one));
        let two = ("var(--two, #2e98b8)", "var(--two-ink, #ffffff)");
        assert_eq!(scaled(0.05), (format!("color-mix(in srgb, {light}, {} 20%)", two.0), one));
        assert_eq!(scaled(0.25), (two.0.to_owned(), two.1));
        assert_eq!(scaled(1.0), ("var(--five, #2c2d7d)".to_owned(), "var(--five-ink, #ffffff)"));
    }

    #[test]
    fn more_improvements_are_darker() {
        let light = |c: Rgb| c.map(u32::from).iter().sum::<u32>();
        for most in 1..9 {
            let mut ranks: Vec<Rank> = (0..=most).map(Rank::Finite).collect();
            ranks.push(Rank::Unbounded);
            let colors: Vec<u32> = ranks.into_iter().map(|r| light(rank(r, most))).collect();
            assert!(colors.windows(2).all(|pair| pair[0] > pair[1]), "{most}: {colors:?}");
        }
    }
}
