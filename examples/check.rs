//! The improvements that a model allows: the regions of a small world, and the ranks of its start.
//!
//! `cargo run --example check`

use std::path::Path;

use meliora::{Kind, Model, Options, Result, Settings, SourceFile};

fn main() -> Result<()> {
    let model = Model::open("models/courier.prism", "")?;
    let wishes = SourceFile::open(Path::new("models/courier.pref"))?;

    // The engine is the first to know all states; `explore` takes that of the settings.
    let mut analysis = model.explore_by_any(Settings::default())?.prefer(&wishes, Options::default())?;
    analysis.run(&mut |_| ())?;
    for name in analysis.region_names() {
        if let Some(region) = analysis.region(name.as_str()) {
            println!("{name:24} {:>4} states", region.count()?);
        }
    }

    // The objectives speak of paths, so a state of the analysis has the values of monitors, too.
    for start in analysis.exploration().initial().list(1)? {
        println!("surely reached and preferred most at the start: {:?}", analysis.most_preferred(&start)?);
        for kind in [Kind::Sasi, Kind::Spi] {
            println!("{kind}: rank {:?}", analysis.rank(kind, &start)?);
        }
    }
    Ok(())
}
