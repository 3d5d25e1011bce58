//! Counts the reachable states of a Boolean network by the saturation of `biodivine-algo-bdd-scc`,
//! for the tool `peer` of `scripts/bench`.
//!
//! Reads the file .bnet named by the only argument and prints the number of states. Initially all
//! variables with a function are false, and the inputs, which keep their value, have any value. The
//! order of the variables is the one that the library chooses: by name.

use std::error::Error;
use std::process::ExitCode;

use biodivine_algo_bdd_scc::reachability::ForwardReachability;
use biodivine_lib_param_bn::symbolic_async_graph::SymbolicAsyncGraph;
use biodivine_lib_param_bn::{BooleanNetwork, FnUpdate, Regulation, VariableId};
use computation_process::Algorithm;

/// Size of the stack in bytes. Brackets in functions may be nested deeply.
const STACK: usize = 1 << 30;

fn main() -> ExitCode {
    let worker = std::thread::Builder::new().stack_size(STACK).spawn(|| count().map_err(|e| e.to_string()));
    match worker.map(|w| w.join()) {
        Ok(Ok(Ok(states))) => {
            println!("{states}");
            ExitCode::SUCCESS
        }
        Ok(Ok(Err(message))) => failed(&message),
        _ => failed("the worker thread failed"),
    }
}

fn failed(message: &str) -> ExitCode {
    eprintln!("error: {message}");
    ExitCode::FAILURE
}

/// Returns the number of reachable states of the network named on the command line.
fn count() -> Result<String, Box<dyn Error>> {
    let path = std::env::args_os().nth(1).ok_or("usage: biodivine-reach NETWORK.bnet")?;
    let mut network = BooleanNetwork::try_from_bnet(&std::fs::read_to_string(path)?)?;
    let (inputs, others): (Vec<_>, Vec<_>) =
        network.variables().partition(|&v| network.get_update_function(v).is_none());
    inputs.into_iter().try_for_each(|v| keep(&mut network, v))?;
    // The reader claims that each function depends on all its variables, which is not always true.
    let graph = SymbolicAsyncGraph::new(&network.remove_static_constraints())?;
    let initial = graph.mk_subspace(&Vec::from_iter(others.into_iter().map(|v| (v, false))));
    let reached = ForwardReachability::run(&graph, initial).map_err(|e| format!("{e:?}"))?;
    Ok(reached.exact_cardinality().to_string())
}

/// Lets an input keep its value. Without a function it could change to the value of a parameter.
fn keep(network: &mut BooleanNetwork, input: VariableId) -> Result<(), String> {
    let itself = Regulation { regulator: input, target: input, observable: false, monotonicity: None };
    network.as_graph_mut().add_raw_regulation(itself)?;
    network.set_update_function(input, Some(FnUpdate::mk_var(input)))
}
