//! `meliora generate`: models and preferences of parametrised families.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};
use meliora_base::error::Error;
use meliora_generate::{self as generate, Choices, Direction, Directions, Empty, Generated, Parameters};

use super::by_name::by_name;
use super::exit::Status;
use super::files::{self, Target};
use super::{load, terminal};

/// Generate a model and preferences of a parametrised family
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  meliora generate gridworld --rows 12 --cols 12 --items 6 --seed 7 --out garden
  meliora generate gridworld --from-map models/robot5x5.map --out robot")]
pub(super) struct GenerateArgs {
    #[command(subcommand)]
    family: Family,
}

#[derive(Debug, Clone, Subcommand)]
enum Family {
    Gridworld(GridworldArgs),
}

/// Generate robots that pick up items in a grid, at random or from a drawn map
#[derive(Debug, Clone, Args)]
struct GridworldArgs {
    /// Number of rows
    #[arg(long, value_name = "N", required_unless_present = "from_map")]
    rows: Option<usize>,

    /// Number of columns
    #[arg(long, value_name = "N", required_unless_present = "from_map")]
    cols: Option<usize>,

    /// Read the grid and everything on it from a map file instead
    #[arg(long, value_name = "FILE", conflicts_with = "random")]
    from_map: Option<PathBuf>,

    #[command(flatten)]
    random: RandomArgs,

    /// Preference order, such as 'D>A,E>=A,B~C' [default: from the map, or random]
    #[arg(long, value_name = "ORDER")]
    prefer: Option<String>,

    /// Value of nothing: how a state without a sure objective compares [default: from the map, or
    /// bottom]
    #[arg(long, value_parser = by_name::<Empty>())]
    empty: Option<Empty>,

    /// Seed of the random numbers: the same seed always gives the same files
    #[arg(long, value_name = "N", default_value_t = 0)]
    seed: u64,

    /// Write PREFIX.prism and PREFIX.pref, or FILE.prism and the FILE.pref next to it; - is stdout
    #[arg(short, long, value_name = "PREFIX")]
    out: Option<PathBuf>,

    /// Overwrite files that exist
    #[arg(long, requires = "out")]
    force: bool,

    /// File that goes to stdout without --out
    #[arg(long, value_enum, default_value_t, conflicts_with = "out")]
    print: Text,
}

/// The options of random worlds.
#[derive(Debug, Clone, Args)]
#[group(id = "random", multiple = true)]
struct RandomArgs {
    /// Number of items, named A, B, C, …
    #[arg(long, value_name = "N", default_value_t = 6)]
    items: usize,

    /// Number of items that become available only after others are picked up [default: half of
    /// those outside the forks]
    #[arg(long, value_name = "N")]
    locked: Option<usize>,

    /// Capacity of the battery, or none for no battery [default: three times the longer side]
    #[arg(long, value_name = "N|none", value_parser = battery)]
    battery: Option<Battery>,

    /// Number of chargers
    #[arg(long, value_name = "N", default_value_t = 1)]
    chargers: usize,

    /// Chargers work from the start; by default an item makes them available
    #[arg(long)]
    open_chargers: bool,

    /// Walls, in percent of the cells
    #[arg(long, value_name = "PERCENT", default_value_t = 10)]
    walls: usize,

    /// Slippery cells, in percent of the cells
    #[arg(long, value_name = "PERCENT", default_value_t = 10)]
    slippery: usize,

    /// Directions in which slippery cells slide; each cell draws one of these sets [default:
    /// NS,EW,NSW]
    #[arg(long, value_name = "NS,…", value_delimiter = ',', value_parser = drift)]
    drift: Vec<Directions>,

    /// Number of cells that can be entered and left in one direction only
    #[arg(long, value_name = "N", default_value_t = 0)]
    one_way: usize,

    /// Number of cells in which two opposite actions are disabled
    #[arg(long, value_name = "N", default_value_t = 0)]
    disabled: usize,

    /// Number of robots
    #[arg(long, value_name = "N", default_value_t = 1)]
    robots: usize,

    /// Number of moving obstacles
    #[arg(long, value_name = "N", default_value_t = 0)]
    patrols: usize,

    /// Number of robots of an opponent, which move after each move of ours and block their cells: the
    /// model is a game
    #[arg(long, value_name = "N", default_value_t = 0)]
    opponent: usize,

    /// Number of forks in a row: dead ends where chance decides between two items that are better
    /// than all before [default: 1, or 2 from 7 items on if there is room]
    #[arg(long, value_name = "N")]
    forks: Option<usize>,
}

/// The capacity of a battery; `None` for no battery.
#[derive(Debug, Clone, Copy)]
struct Battery(Option<u32>);

/// One of the two files.
#[derive(Debug, Clone, Copy, Default, ValueEnum)]
enum Text {
    /// Model
    #[default]
    Model,
    /// Preference file
    Prefs,
}

/// Runs the command.
///
/// # Errors
/// The parameters or the map are wrong, or a file cannot be written.
pub(super) fn run(args: &GenerateArgs) -> Result<Status, Error> {
    let Family::Gridworld(args) = &args.family;
    let choices = Choices { prefer: args.prefer.clone(), empty: args.empty, seed: args.seed };
    let generated = match &args.from_map {
        Some(path) => generate::from_map(&load::read(path)?, &choices)?,
        None => generate::gridworld(&args.parameters(), &choices)?,
    };
    match (&args.out, args.print) {
        (Some(prefix), _) if prefix.as_os_str() != "-" => write(prefix, &generated, args)?,
        (_, Text::Model) => terminal::print_bytes(generated.model.as_bytes())?,
        (_, Text::Prefs) => terminal::print_bytes(generated.preferences.as_bytes())?,
    }
    Ok(Status::Done)
}

impl GridworldArgs {
    fn parameters(&self) -> Parameters {
        let random = &self.random;
        // The parser requires both.
        let (rows, cols) = (self.rows.unwrap_or_default(), self.cols.unwrap_or_default());
        let standard = Parameters::new(rows, cols, random.items);
        let forks = random.forks.unwrap_or(standard.forks);
        Parameters {
            forks,
            battery: random.battery.map_or(standard.battery, |Battery(full)| full),
            locked: random.locked.unwrap_or(random.items.saturating_sub(2 * forks) / 2),
            chargers: random.chargers,
            locked_charger: !random.open_chargers,
            walls: random.walls,
            slippery: random.slippery,
            drifts: if random.drift.is_empty() { standard.drifts } else { random.drift.clone() },
            one_way: random.one_way,
            disabled: random.disabled,
            robots: random.robots,
            patrols: random.patrols,
            opponents: random.opponent,
            ..standard
        }
    }
}

fn battery(text: &str) -> Result<Battery, String> {
    match text {
        "none" => Ok(Battery(None)),
        _ => {
            text.parse().map(|full| Battery(Some(full))).map_err(|_| "expected a number, or none".to_owned())
        }
    }
}

fn drift(text: &str) -> Result<Directions, String> {
    let direction = |c: char| {
        let known = Direction::ALL.into_iter().find(|d| d.letter() == c);
        known.ok_or_else(|| format!("`{c}` is not a direction: expected letters from NSEW, such as NS"))
    };
    text.chars().map(direction).collect()
}

/// Writes both files or none.
fn write(prefix: &Path, generated: &Generated, args: &GridworldArgs) -> Result<(), Error> {
    let inputs: Vec<&Path> = args.from_map.iter().map(PathBuf::as_path).collect();
    // A prefix may be written with the extension of one of its files, but have another dot.
    let is_file = prefix.extension().is_some_and(|end| end == "prism" || end == "pref");
    let prefix = if is_file { prefix.with_extension("") } else { prefix.to_owned() };
    let target = |extension: &str| {
        let mut name = prefix.as_os_str().to_owned();
        name.push(extension);
        Target::new(Path::new(&name), &inputs)
    };
    let (model, preferences) = (target(".prism")?, target(".pref")?);
    if let Some(taken) = [&model, &preferences].into_iter().find(|t| t.is_taken() && !args.force) {
        let message = "the file exists; `--force` overwrites it".to_owned();
        return Err(Error::Io { path: taken.path().display().to_string(), message });
    }
    let texts = [(&model, generated.model.as_bytes()), (&preferences, generated.preferences.as_bytes())];
    files::write_all(&texts)?;
    let written = terminal::stdout_style().good("written");
    terminal::print(&format!("{written}: {} and {}\n", model.path().display(), preferences.path().display()))
}
