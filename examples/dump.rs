//! Regions for other programs: a dump is written, checked by one-step conditions, and asked without the model.
//!
//! `cargo run --example dump`

use std::path::Path;

use meliora::query::Archive;
use meliora::{Model, Options, Result, Settings, SourceFile};

fn main() -> Result<()> {
    let model = Model::open("models/toy.prism", "")?;
    let wishes = SourceFile::open(Path::new("models/toy.pref"))?;
    let mut analysis = model.explore(Settings::default())?.prefer(&wishes, Options::default())?;
    analysis.run(&mut |_| ())?;

    let folder = std::env::temp_dir().join("meliora-example.dump");
    analysis.export(&wishes, &folder)?;
    let (_, verdict) = model.verify(&wishes, &folder, Settings::default())?;
    println!("{} regions were checked; all are proved: {}", verdict.checked.len(), verdict.is_accepted());

    let archive = Archive::open(&folder, None, Settings::default())?;
    let found = archive.select("sasi:1 & !spi:2")?;
    for member in archive.list(&found, 10)? {
        println!("one improvement, and not two: {}", archive.program().show_state(&member.state));
    }
    Ok(())
}
