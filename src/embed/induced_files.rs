//! The chain that the strategy of a property leaves, for other programs.

use meliora_base::error::Result;
use meliora_base::exact::{Ratio, Real};
use meliora_base::progress::ProgressSink;
use meliora_export::explicit::{Graph, Row, chain, drn, prism, program_text, state_rewards, umb_of_chain};
use meliora_model::{Program, fault};
use meliora_question::evaluate::PropertyPolicy;

meliora_base::named! {
    /// The format of an induced chain.
    #[derive(Default)]
    pub enum ChainFormat {
        /// PRISM's `.tra`, `.sta` and `.lab`, and one `.srew` for each reward structure.
        #[default]
        Tra,
        /// Storm's `.drn`.
        Drn,
        /// UMB's `.umb`.
        Umb,
        /// A program of PRISM.
        Prism,
    }
}

/// The name of all files.
const STEM: &str = "strategy";

impl ChainFormat {
    /// Returns the names of the files for a program, in the order of [`ChainFormat::contents`].
    pub fn names(self, program: &Program) -> Vec<String> {
        let own: Vec<String> = match self {
            ChainFormat::Tra => {
                let rewards = (1..=program.rewards.len()).map(|number| format!("{number}.srew"));
                ["tra", "sta", "lab"].map(str::to_owned).into_iter().chain(rewards).collect()
            }
            ChainFormat::Drn => vec!["drn".to_owned()],
            ChainFormat::Umb => vec!["umb".to_owned()],
            ChainFormat::Prism => vec!["prism".to_owned()],
        };
        own.iter().map(|extension| format!("{STEM}.{extension}")).collect()
    }

    /// Returns the contents of the files of a strategy. Cost: one step of the program per node.
    ///
    /// # Errors
    /// The program has no meaning in a state; a limit is reached.
    pub fn contents(
        self,
        policy: &PropertyPolicy,
        program: &Program,
        sink: &dyn ProgressSink,
    ) -> Result<Vec<Vec<u8>>> {
        let graph = graph(policy, program)?;
        Ok(match self {
            ChainFormat::Tra => {
                let all = prism(&graph);
                let mut texts = vec![all.tra, all.sta, all.lab];
                texts.extend(state_rewards(&graph, program, sink)?);
                texts.resize(3 + program.rewards.len(), String::new());
                texts.into_iter().map(String::into_bytes).collect()
            }
            ChainFormat::Drn => vec![drn(&graph, program, sink)?.into_bytes()],
            ChainFormat::Umb => vec![umb_of_chain(&graph, program, sink)?],
            ChainFormat::Prism => vec![program_text(&graph, program, sink)?.into_bytes()],
        })
    }
}

/// Returns the chain of a strategy; where a path is decided, it stays.
fn graph(policy: &PropertyPolicy, program: &Program) -> Result<Graph> {
    let mut nodes = Vec::with_capacity(policy.nodes.count());
    policy.nodes.each(|number, node| {
        let names = program.choices(&node.state).map_err(|f| fault::error(program, &f, &node.state))?;
        let mut rows: Vec<Row> = Vec::with_capacity(node.choices.len());
        for taking in &node.choices {
            let action = names.get(taking.position).map(|(_, name)| name.clone()).unwrap_or_default();
            let to = taking.successors.iter().map(|(to, p)| (*to, Real::Finite(Ratio::clone(p)).to_f64()));
            let mut successors: Vec<(usize, f64)> = to.collect();
            successors.sort_by_key(|successor| successor.0);
            rows.push(Row { action, successors });
        }
        if rows.is_empty() {
            rows.push(Row { action: "decided".to_owned(), successors: vec![(number, 1.0)] });
        }
        nodes.push((node.state.clone(), rows));
        Ok(())
    })?;
    chain(program, nodes, policy.starts)
}
