//! `meliora reach` with several properties, from a file or from the command line.
//!
//! All reachability properties share one engine. A temporal formula has its own, with its monitors.
//! The regions that the properties need are computed first, the cheapest of each target before the
//! others, and the numbers last. Therefore a limit leaves as many answers as possible.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ahash::AHashMap;
use meliora::reach::{Asking, Target, Under};
use meliora_engine::regions::Which;
use meliora_engine::{Engine, Selection};
use meliora_lang::refusal::Refusal;
use meliora_lang::{
    Document, open_constants, outline_properties, parse_properties, refuse_values, split_constants,
};
use meliora_model::Program;
use meliora_model::error::{Error, SourceFile};
use meliora_planning::RegionSearch;
use meliora_planning::result::ModelCounts;
use meliora_report::PropertiesReport;
use meliora_report::properties::PropertyAnswer;

use super::engines;
use super::exit::Status;
use super::load::{self, Asked, Stated};
use super::options::{EngineArgs, ModelArgs, ShownArgs};
use super::regions::{Found, Regions};
use super::supervise::{Job, supervise};

/// The arguments for a property file.
pub(super) struct Questions {
    pub(super) model: ModelArgs,
    pub(super) engine: EngineArgs,
    pub(super) file: PathBuf,
    pub(super) only: Option<String>,
    pub(super) require: Vec<String>,
    pub(super) precision: f64,
    pub(super) out: Option<PathBuf>,
}

fn report(model: &ModelArgs, engine: EngineArgs) -> PropertiesReport {
    PropertiesReport::new(engine.header(model.header()))
}

/// Runs the command for a property file.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn run(questions: Questions, shown: &ShownArgs) -> Result<Status, Error> {
    let mut report = report(&questions.model, questions.engine);
    report.header.file = Some(questions.file.display().to_string());
    let shown = shown.of(&questions.model);
    supervise(report, questions.model.limits(), &shown, move |job| {
        let (asked, open) = job.timed("parse", || read(job, &questions), |r, s| r.time.add("parse", s))?;
        let args = Arguments::new(&questions.model, questions.engine, questions.out.as_deref())?;
        work(job, &args, &asked, &open, questions.precision)
    })
}

/// Properties of the command line: their texts, or all that the model names.
pub(super) enum Several {
    Texts(Vec<String>),
    Named,
}

/// Runs the command for properties of the command line.
///
/// # Errors
/// The input is wrong, or a limit is hit.
pub(super) fn several(
    (model, engine, out): (ModelArgs, EngineArgs, Option<PathBuf>),
    (properties, require, precision): (Several, Vec<String>, f64),
    shown: &ShownArgs,
) -> Result<Status, Error> {
    let report = report(&model, engine);
    let (shown, limits) = (shown.of(&model), model.limits());
    supervise(report, limits, &shown, move |job| {
        let read = || match &properties {
            Several::Texts(texts) => {
                let asked = load::asked(&model, None, (texts, &require), &job.sink)?;
                let entry = |q: &Stated| PropertyAnswer::open(None, q.text.clone(), None);
                let entries = asked.questions.iter().map(entry).collect();
                Ok((asked, entries))
            }
            Several::Named => load::named(&model, &require, &job.sink).map(|(asked, unanswered)| {
                let entry = |(name, refusal)| entry(None, name, refusal);
                (asked, unanswered.into_iter().map(entry).collect())
            }),
        };
        let (asked, entries): (Asked, Vec<PropertyAnswer>) =
            job.timed("parse", read, |r, s| r.time.add("parse", s))?;
        let open = (0..entries.len()).filter(|&at| entries[at].reason.is_none()).collect::<Vec<_>>();
        warn_of_none(job, &open, entries.len());
        job.update(|r| r.properties = entries);
        work(job, &Arguments::new(&model, engine, out.as_deref())?, &asked, &open, precision)
    })
}

/// Returns the names of the properties of a file, or their texts where they have no name.
///
/// # Errors
/// The file cannot be read; it has no such property, or has the value of a given constant already.
pub(super) fn titles(file: &Path, only: Option<&str>, constants: &str) -> Result<Vec<String>, Error> {
    let source = load::read(file)?;
    refuse_values(&source, &SourceFile::new("--const", constants))?;
    let all = outline_properties(&source)?.into_iter();
    let chosen: Vec<_> =
        all.filter(|(name, _)| only.is_none_or(|only| name.as_deref() == Some(only))).collect();
    if let (Some(only), true) = (only, chosen.is_empty()) {
        return Err(no_property(&source, only));
    }
    Ok(chosen.into_iter().map(|(name, text)| name.unwrap_or(text)).collect())
}

/// Checks the definitions of a property file.
///
/// # Errors
/// The file cannot be read, or a definition is wrong.
pub(super) fn check(file: &Path, mut program: Program) -> Result<(), Error> {
    let none = SourceFile::new("--const", "");
    parse_properties(&load::read(file)?, &none, &mut program).map(drop)
}

fn no_property(source: &SourceFile, name: &str) -> Error {
    Error::Usage(format!("{} has no property with the name `{name}`", source.name))
}

/// Reads the model with the definitions of the file, the properties that can be answered, and their
/// positions in the report.
fn read(job: &Job<PropertiesReport>, questions: &Questions) -> Result<(Asked, Vec<usize>), Error> {
    let source = load::read(&questions.file)?;
    let given = SourceFile::new("--const", questions.model.constants());
    refuse_values(&source, &given)?;
    let mut open = open_constants(&source)?;
    if !open.is_empty() && questions.model.model != Path::new("-") {
        // A constant that both declare is refused at its place in the file.
        let declared = Document::open(&questions.model.model)?.constants();
        open.retain(|name| !declared.contains(name));
    }
    let [theirs, others] = split_constants(&given, &open)?;
    let model = questions.model.with_constants(&others.text);
    let (program, overlap) = load::program(&model, &job.sink)?;
    let mut program = Arc::unwrap_or_clone(program);
    let mut stated = parse_properties(&source, &theirs, &mut program)?;
    let required = load::required(&questions.require)?;
    if let Some(only) = &questions.only {
        stated.retain(|s| s.name.as_ref() == Some(only));
        if stated.is_empty() {
            return Err(no_property(&source, only));
        }
    }
    let (mut open, mut asking, mut count) = (Vec::new(), Vec::new(), 0);
    for (position, stated) in stated.into_iter().enumerate() {
        count += 1;
        let own = match &stated.property {
            Ok(property) => {
                load::alone(&source, Asking::of_property(&program, &source, property, &required))?
            }
            Err(refusal) => Err(refusal.clone()),
        };
        let entry = entry(stated.name, stated.text.clone(), own.as_ref().err().cloned());
        job.update(|r| r.properties.push(entry));
        if let Ok(own) = own {
            asking.push(Stated { text: stated.text, asking: own });
            open.push(position);
        }
    }
    warn_of_none(job, &open, count);
    Ok((Asked::new(program, (asking, true), overlap), open))
}

/// Returns the entry of a property in the report, with the reason for no answer.
fn entry(name: Option<String>, text: String, refusal: Option<Refusal>) -> PropertyAnswer {
    let (reason, place) = refusal.map(|refusal| (refusal.reason, refusal.place)).unzip();
    PropertyAnswer::open(name, text, reason).at(place.flatten())
}

/// Warns that none of the properties can be answered.
fn warn_of_none(job: &Job<PropertiesReport>, open: &[usize], count: usize) {
    if open.is_empty() && count > 0 {
        job.sink.warn("none of the properties can be answered: see the reasons");
    }
}

/// The arguments for the engine, and where the regions are written.
struct Arguments<'a> {
    model: &'a ModelArgs,
    engine: EngineArgs,
    out: Option<Regions<'a>>,
}

impl<'a> Arguments<'a> {
    fn new(model: &'a ModelArgs, engine: EngineArgs, out: Option<&'a Path>) -> Result<Self, Error> {
        let out = out.map(|out| Regions::new(out, model, engine)).transpose()?;
        Ok(Arguments { model, engine, out })
    }
}

/// Answers the reachability properties with one engine, then each formula with its own.
fn work(
    job: &Job<PropertiesReport>,
    args: &Arguments<'_>,
    asked: &Asked,
    open: &[usize],
    precision: f64,
) -> Result<(), Error> {
    let watched = asked.questions.iter().map(|q| q.asking.goal.program(&asked.program));
    let selected = match args.out {
        Some(_) => args.engine.diagrams("`--out` writes diagrams"),
        None => args.engine.select(watched.chain([&asked.program]).map(|program| &**program), args.model),
    };
    job.update(|r| {
        r.header.read(&asked.program);
        r.header.select(&selected);
    });
    let all = || asked.questions.iter().map(|q| &q.asking).zip(open.iter().copied());
    if let Some(out) = &args.out {
        return write_regions(job, (args.model, out), asked, &Vec::from_iter(all()), precision);
    }
    let args = (args.model, &selected);
    let plain: Vec<_> = all().filter(|(q, _)| q.goal.watched.is_none()).collect();
    if !plain.is_empty() || asked.questions.is_empty() {
        run_engine(job, args, asked, &asked.program, &plain, precision)?;
    }
    for question in all() {
        if let Some(watched) = &question.0.goal.watched {
            run_engine(job, args, asked, &watched.program, &[question], precision)?;
        }
    }
    Ok(())
}

/// Answers properties with one engine of diagrams, and writes their regions.
fn write_regions(
    job: &Job<PropertiesReport>,
    (model, out): (&ModelArgs, &Regions<'_>),
    asked: &Asked,
    questions: &[(&Asking, usize)],
    precision: f64,
) -> Result<(), Error> {
    let texts = asked.questions.iter().map(|q| (&q.asking, q.text.as_str()));
    Regions::check(&Vec::from_iter(texts))?;
    let program = questions.first().map_or(&asked.program, |(first, _)| first.goal.program(&asked.program));
    let engine = job.timed("build", || engines::symbolic(program, model, &job.sink), |_, _| ())?;
    let questions = answerable(job, &*engine, asked, questions)?;
    let mut kept = Some(Vec::new());
    let unsafe_states = answer(job, &*engine, asked, &questions, precision, &mut kept)?;
    let place = |(at, which, states)| {
        let position = questions.iter().position(|(_, position)| *position == at)?;
        Some((position, which, states))
    };
    let found = kept.into_iter().flatten().filter_map(place).collect();
    let mut named = Vec::new();
    job.update(|r| {
        let entry = |&(asking, at): &(_, usize)| {
            let PropertyAnswer { name, property, .. } = &r.properties[at];
            (asking, name.clone(), property.clone())
        };
        named.extend(questions.iter().map(entry));
    });
    let write = || out.write((&engine, asked), &named, &found, unsafe_states.as_ref(), &job.sink);
    let written = job.timed("write", write, |_, _| ())?;
    job.update(|r| r.written = Some(written));
    Ok(())
}

fn run_engine(
    job: &Job<PropertiesReport>,
    (model, selected): (&ModelArgs, &Selection),
    asked: &Asked,
    program: &Arc<Program>,
    questions: &[(&Asking, usize)],
    precision: f64,
) -> Result<(), Error> {
    let mut selected = selected.clone();
    let lists_states = questions.iter().any(|(asking, _)| asking.asks_for_number());
    let build = || engines::engine_for(program, model, &mut selected, lists_states, &job.sink);
    let engine = job.timed("build", build, |r, s| r.time.add("build", s))?;
    job.update(|r| r.header.select(&selected));
    let questions = answerable(job, &*engine, asked, questions)?;
    answer(job, &*engine, asked, &questions, precision, &mut None).map(drop)
}

/// Returns the questions that have a meaning for the initial states of the model.
///
/// # Errors
/// A limit is hit; a question of the command line has no meaning.
fn answerable<'a, E: Engine>(
    job: &Job<PropertiesReport>,
    engine: &E,
    asked: &Asked,
    questions: &[(&'a Asking, usize)],
) -> Result<Vec<(&'a Asking, usize)>, Error> {
    let mut left = Vec::new();
    for &(asking, position) in questions {
        match asking.refused(engine)? {
            None => left.push((asking, position)),
            Some(reason) if asked.is_list => job.update(|r| r.properties[position].reason = Some(reason)),
            Some(reason) => return Err(load::not_answered(&asked.questions[position].text, &reason)),
        }
    }
    Ok(left)
}

/// Answers properties of one program. Regions go to `kept`, if there is a list. Returns the unsafe states
/// under requirements.
fn answer<E: Engine>(
    job: &Job<PropertiesReport>,
    engine: &E,
    asked: &Asked,
    questions: &[(&Asking, usize)],
    precision: f64,
    kept: &mut Option<Found<E::States>>,
) -> Result<Option<E::States>, Error> {
    let Some((first, _)) = questions.first() else {
        let all = engine.all_states();
        let counts =
            job.timed("count", || ModelCounts::within(engine, &all), |r, s| r.time.add("build", s))?;
        job.update(|r| r.counts = Some(counts));
        return Ok(None);
    };
    let under = Under::new(engine, &asked.program, &first.goal)?;
    let counts = job.timed("count", || under.counts(&first.goal), |r, s| r.time.add("build", s))?;
    let mut known = false;
    job.update(|r| known = r.counts.is_some());
    if !known {
        engines::warn_of_states(
            &job.sink,
            engine,
            &asked.program,
            &counts.deadlocks,
            asked.overlap.as_ref(),
        )?;
        job.update(|r| (r.counts, r.escape) = (Some(counts), under.escape.clone()));
    }
    for questions in by_coalition(questions) {
        let (first, _) = questions[0];
        let played = first.played(engine)?;
        let own = played.as_ref().map(|game| Under::new(game, &asked.program, &first.goal)).transpose()?;
        answer_under(job, own.as_ref().unwrap_or(&under), asked, &questions, (precision, kept))?;
    }
    Ok(under.unsafe_states().cloned())
}

/// Separates the properties of a game by the players who choose.
fn by_coalition<'a>(questions: &[(&'a Asking, usize)]) -> Vec<Vec<(&'a Asking, usize)>> {
    let mut all: Vec<Vec<(&Asking, usize)>> = Vec::new();
    for &question in questions {
        match all.iter_mut().find(|own| own[0].0.coalition == question.0.coalition) {
            Some(own) => own.push(question),
            None => all.push(vec![question]),
        }
    }
    all
}

/// Answers properties of the same players.
fn answer_under<E: Engine>(
    job: &Job<PropertiesReport>,
    under: &Under<'_, E>,
    asked: &Asked,
    questions: &[(&Asking, usize)],
    (precision, kept): (f64, &mut Option<Found<E::States>>),
) -> Result<(), Error> {
    let mut groups = groups(under.engine(), &asked.program, questions)?;
    let answering = Answering { job, under, asked };
    for round in 0..Which::ALL.len() {
        for group in &mut groups {
            let Some((which, states)) = answering.find(group, round)? else { continue };
            if let Some(kept) = kept {
                kept.extend(group.members.iter().map(|(_, position)| (*position, which, states.clone())));
            }
        }
        groups.retain(|group| group.asks_for_numbers() || round + 1 < group.order.len());
    }
    groups.iter().try_for_each(|group| answering.values(group, precision))
}

/// Properties with the same goal.
struct Group<'a, E: Engine> {
    /// The properties, with their positions in the report.
    members: Vec<(&'a Asking, usize)>,
    /// The regions that they need.
    order: Vec<Which>,
    search: RegionSearch<'a, E>,
    /// The states whose paths are judged.
    judged: E::States,
}

/// Groups properties by their goals, in the order of the first of each.
fn groups<'a, E: Engine>(
    engine: &'a E,
    program: &Arc<Program>,
    questions: &[(&'a Asking, usize)],
) -> Result<Vec<Group<'a, E>>, Error> {
    let same = |a: &Asking, b: &Asking| match (&a.goal.target, &b.goal.target) {
        (Target::States(one), Target::States(other)) => one.is_same(other),
        _ => false,
    };
    let mut groups: Vec<Group<'a, E>> = Vec::new();
    // The groups by the fingerprints of their targets.
    let mut known: AHashMap<u64, Vec<usize>> = AHashMap::new();
    for &(asking, position) in questions {
        let alike = match &asking.goal.target {
            Target::States(target) => Some(known.entry(target.fingerprint()).or_default()),
            _ => None,
        };
        let same = |&&group: &&usize| same(groups[group].members[0].0, asking);
        match alike.as_ref().and_then(|alike| alike.iter().find(same).copied()) {
            Some(group) => groups[group].members.push((asking, position)),
            None => {
                alike.into_iter().for_each(|alike| alike.push(groups.len()));
                let (search, judged) = (asking.goal.search(engine)?, asking.goal.judged(engine)?);
                groups.push(Group { members: vec![(asking, position)], order: Vec::new(), search, judged });
            }
        }
    }
    for group in &mut groups {
        let needed: Vec<Which> = group.members.iter().flat_map(|(q, _)| q.needed(program)).collect();
        group.order = group.search.order(&needed);
    }
    Ok(groups)
}

impl<E: Engine> Group<'_, E> {
    fn asks_for_numbers(&self) -> bool {
        self.members.iter().any(|(asking, _)| asking.asks_for_number())
    }
}

struct Answering<'a, E: Engine> {
    job: &'a Job<PropertiesReport>,
    under: &'a Under<'a, E>,
    asked: &'a Asked,
}

impl<E: Engine> Answering<'_, E> {
    /// Computes the region of a round, and adds it and the decided verdicts to the report. Returns it within
    /// the states that are judged; `None` if no region is left.
    fn find(&self, group: &mut Group<'_, E>, round: usize) -> Result<Option<(Which, E::States)>, Error> {
        let Some(&which) = group.order.get(round) else { return Ok(None) };
        let region = || group.search.region(which);
        let states = self.job.timed(which.formula(), region, |r, s| r.time.add(which.name(), s))?;
        let engine = self.under.engine();
        let inside = engine.intersection(&states, &group.judged)?;
        let size = engine.count(&inside)?;
        for &(asking, position) in &group.members {
            let decided = self.under.decided(asking, &self.asked.program, group.search.known())?;
            self.job.update(|r| {
                r.properties[position].answer(&decided);
                *r.properties[position].sizes.get_mut(which) = Some(size.clone().into());
                r.memory.peak_nodes = r.memory.peak_nodes.max(engine.usage().peak_nodes);
            });
        }
        Ok(Some((which, inside)))
    }

    /// Answers the properties that ask for numbers.
    fn values(&self, group: &Group<'_, E>, precision: f64) -> Result<(), Error> {
        for &(asking, position) in group.members.iter().filter(|(asking, _)| asking.asks_for_number()) {
            let program = &self.asked.program;
            let answer = || self.under.answer(asking, program, group.search.known(), precision);
            let answer = match self.job.timed("value", answer, |r, s| r.time.add("value", s)) {
                // A wrong reward.
                Err(error @ Error::Input(_)) if self.asked.is_list => {
                    let reason = Refusal::of(&error).reason;
                    self.job.update(|r| r.properties[position].reason = Some(reason));
                    continue;
                }
                answer => answer?,
            };
            self.job.update(|r| r.properties[position].answer(&answer));
            // A number of a game that is not supported leaves the others.
            if answer.no_value.is_none() {
                answer.end?;
            }
        }
        Ok(())
    }
}
