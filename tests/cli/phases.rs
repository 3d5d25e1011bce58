//! The phases of a run and their times.

/// The phases that `-v` names, with their seconds.
fn phases(stderr: &str) -> Vec<(&str, f64)> {
    let phase = |line: &'_ str| -> Option<(usize, f64)> {
        let (name, seconds) = line.rsplit_once(": ")?;
        Some((name.len(), seconds.strip_suffix(" s")?.parse().ok()?))
    };
    stderr.lines().filter_map(|line| phase(line).map(|(end, seconds)| (&line[..end], seconds))).collect()
}

#[test]
fn the_phases_of_a_run_add_up_to_it_and_each_has_a_name() {
    let model = "models/robot5x5.prism";
    for (command, named) in [
        (
            format!("reach {model} --target b=0"),
            vec!["parse", "build", "count", "Pmax > 0", "Pmin = 1", "release"],
        ),
        (
            format!("check {model} models/robot5x5.pref"),
            vec!["parse", "outcomes", "SPI", "initial states", "release"],
        ),
        (format!("values {model} models/robot5x5.pref"), vec!["levels", "explore", "solve", "release"]),
        (format!("info {model}"), vec!["parse", "build", "count", "release"]),
    ] {
        let finished = run!("{command} --engine symbolic -v --json").expect(0);
        let (phases, total) = (phases(&finished.stderr), finished.json()["time"]["total"].as_f64().unwrap());
        for name in named {
            let is_it = |(phase, _): &(&str, f64)| phase.eq_ignore_ascii_case(name);
            assert!(phases.iter().any(is_it), "{command}: {name} in {phases:?}");
        }
        let sum: f64 = phases.iter().map(|(_, seconds)| seconds).sum();
        // Each line is rounded, and the process may wait for the processor after the last one.
        let rounding = 0.0005 * phases.len() as f64;
        assert!(
            sum <= total + rounding && sum >= 0.95 * total - rounding - 0.1,
            "{command}: {sum} of {total}"
        );
    }
}
