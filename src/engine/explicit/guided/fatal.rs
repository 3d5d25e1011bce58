//! Commands that no strategy takes: one of their outcomes is lost wherever they are enabled.
//!
//! A command that leads to the target on short paths, with an outcome that is lost, draws each search to it, from many
//! states. So the first time that such an outcome is met, the command is judged: if no relaxed plan begins with the
//! outcome, whatever the values are that the command neither tests nor writes, it is fatal. It is left out of later
//! estimates, which then say more about other states, too.

use super::Guided;
use super::relaxation::outcomes;
use meliora_model::CommandId;
use meliora_space::index::NOBODY;

impl Guided {
    /// Judges the command of a choice that may step into a state without a relaxed plan. Returns whether it is found to
    /// be fatal.
    pub(super) fn judge(&mut self, choice: u32) -> bool {
        let command = self.part.command_of(choice);
        if command == NOBODY || std::mem::replace(&mut self.guide.judged[command as usize], true) {
            return false;
        }
        let (id, program) = (CommandId(command), &self.task.program);
        let guide = &mut self.guide;
        // Other commands of the same choice would write more variables.
        let is_alone = |&at: &u32| program.synchronisations[at as usize].factors.len() == 1;
        if !guide.relaxation.synchronisations.of(command as usize).iter().all(is_alone) {
            return false;
        }
        let is_fatal = outcomes(program, id).any(|branch| {
            let start = guide.relaxation.after(program, id, branch);
            guide.estimator.estimate(&guide.relaxation, &start).is_none()
        });
        if is_fatal {
            guide.fatal[command as usize] = true;
            guide.age += 1;
            guide.estimator.forbid(&guide.relaxation, command);
        }
        is_fatal
    }

    /// Estimates the distance of an expanded state again if more commands are known to be fatal now, and gives up their
    /// choices. Returns false if the state is lost.
    pub(super) fn renew(&mut self, state: u32) -> bool {
        if self.part.standing[state as usize].age == self.guide.age {
            return true;
        }
        if !self.estimate(state) {
            return false;
        }
        for choice in self.part.choices_of(state) {
            let command = self.part.command_of(choice);
            if command != NOBODY {
                self.part.suggest(choice, self.guide.estimator.is_helpful(command));
                if self.guide.fatal[command as usize] {
                    self.part.close(choice);
                }
            }
        }
        !self.part.standing[state as usize].is_lost
    }
}
