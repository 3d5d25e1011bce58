//! Output files: paths that already exist, paths that are not regular files, and the files left over when
//! the work ends early.

use std::fs::Permissions;
use std::io::Read;
use std::os::unix::fs::{FileTypeExt, MetadataExt, PermissionsExt, symlink};
use std::process::{Command, Stdio};

use crate::common::prelude::*;

const TOY: &str = "models/toy.prism models/toy.pref";

/// A page of the toy with a path for `--out`.
fn report(out: &str) -> Finished {
    run!("report {TOY} --format dot --out {out} -q")
}

fn mode(path: &Path) -> u32 {
    fs::metadata(path).unwrap().mode() & 0o7777
}

fn names(folder: &Path) -> Vec<String> {
    let mut names: Vec<_> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort();
    names
}

/// A command in a shell, in the folder of the project.
fn shell(script: &str) -> Finished {
    let mut command = Command::new("sh");
    command.args(["-c", script]).env("MELIORA", env!("CARGO_BIN_EXE_meliora"));
    Finished::of(command.current_dir(env!("CARGO_MANIFEST_DIR")))
}

#[test]
fn a_file_is_replaced_whole_and_keeps_its_mode_and_its_links() {
    let scratch = Scratch::new(&[("old", "old"), ("secret", "old")]);
    fs::set_permissions(scratch.path("secret"), Permissions::from_mode(0o640)).unwrap();
    symlink("secret", scratch.path("link")).unwrap();
    symlink("new", scratch.path("dangling")).unwrap();
    for (out, end) in [("old", "old"), ("link", "secret"), ("dangling", "new")] {
        report(&scratch.show(out)).expect(0);
        assert!(scratch.read(end).contains("digraph"), "{out}");
    }
    assert_eq!(fs::read_link(scratch.path("link")).unwrap(), Path::new("secret"));
    assert_eq!(fs::read_link(scratch.path("dangling")).unwrap(), Path::new("new"));
    assert_eq!(mode(&scratch.path("secret")), 0o640);
    assert_eq!(names(&scratch.path("")), ["dangling", "link", "new", "old", "secret"]);
}

#[test]
fn what_is_no_regular_file_is_written_through() {
    let scratch = Scratch::new(&[]);
    symlink("/dev/null", scratch.path("null")).unwrap();
    report(&scratch.show("null")).expect(0);
    assert!(fs::metadata(scratch.path("null")).unwrap().file_type().is_char_device());
    assert!(fs::symlink_metadata(scratch.path("null")).unwrap().is_symlink());
    let fifo = scratch.path("fifo");
    assert!(Command::new("mkfifo").arg(&fifo).status().unwrap().success());
    let reader = std::thread::spawn({
        let fifo = fifo.clone();
        move || fs::read_to_string(fifo).unwrap()
    });
    report(&scratch.show("fifo")).expect(0);
    assert!(reader.join().unwrap().contains("digraph"));
    assert!(fs::metadata(&fifo).unwrap().file_type().is_fifo());
    if Path::new("/dev/full").exists() {
        symlink("/dev/full", scratch.path("full")).unwrap();
        report(&scratch.show("full")).ends(4, "could not be written");
    }
}

#[test]
fn a_hyphen_and_dev_stdout_name_standard_output() {
    let plain = run!("report {TOY} --format dot -q").expect(0).stdout;
    assert_eq!(run!("report {TOY} --format dot -q --out -").expect(0).stdout, plain);
    // A pipe, into which nothing else is told.
    assert_eq!(run!("report {TOY} --format dot --out /dev/stdout").expect(0).stdout, plain);
    let scratch = Scratch::new(&[]);
    let file = scratch.show("x");
    shell(&format!("(echo first; $MELIORA report {TOY} --format dot -q --out /dev/stdout) > {file}"))
        .expect(0);
    assert_eq!(fs::read_to_string(&file).unwrap(), format!("first\n{plain}"));
    run!("report {TOY} --json --out -").expect(2);
    run!("export {TOY} --out -").expect(2);
    let world = "generate gridworld --rows 4 --cols 4 --items 2";
    assert_eq!(run!("{world} --out -").expect(0).stdout, run(world).expect(0).stdout);
}

#[test]
fn inputs_read_only_files_and_directories_are_refused_by_the_name_that_was_given() {
    let text = |name: &str| fs::read_to_string(format!("models/toy.{name}")).unwrap();
    let scratch = Scratch::new(&[("m.prism", &text("prism")), ("m.pref", &text("pref")), ("fixed", "old")]);
    let (model, preferences) = (scratch.show("m.prism"), scratch.show("m.pref"));
    symlink("m.prism", scratch.path("link")).unwrap();
    fs::hard_link(scratch.path("m.pref"), scratch.path("hard")).unwrap();
    fs::set_permissions(scratch.path("fixed"), Permissions::from_mode(0o444)).unwrap();
    for (out, status, word) in [
        ("m.prism", 2, "an input of this run"),
        ("link", 2, "an input of this run"),
        ("hard", 2, "an input of this run"),
        ("fixed", 3, "read-only"),
        ("", 3, "directory"),
        ("no/such/page", 3, "does not exist"),
        ("m.prism/page", 3, "directory"),
    ] {
        let out = scratch.show(out);
        let finished = run!("report {model} {preferences} --out {out}").expect(status);
        finished.says(word).says(&out);
        assert!(!finished.stderr.replace(&scratch.show(""), "").contains(".tmp"), "{}", finished.stderr);
    }
    assert_eq!(fs::read_to_string(&model).unwrap(), text("prism"));
    assert_eq!(fs::read_to_string(&preferences).unwrap(), text("pref"));
    assert_eq!(scratch.read("fixed"), "old");
    assert_eq!(names(&scratch.path("")), ["fixed", "hard", "link", "m.pref", "m.prism"]);
}

#[test]
fn generate_writes_both_files_or_none_and_overwrites_only_when_told() {
    let scratch = Scratch::new(&[("w.pref", "mine")]);
    let world = format!("generate gridworld --rows 4 --cols 4 --items 2 --out {}", scratch.show("w"));
    run(&world).ends(3, "--force").says("w.pref");
    assert_eq!(names(&scratch.path("")), ["w.pref"]);
    assert_eq!(scratch.read("w.pref"), "mine");
    run!("{world} --force").expect(0);
    let written = scratch.read("w.pref");
    fs::remove_file(scratch.path("w.prism")).unwrap();
    fs::create_dir(scratch.path("w.prism")).unwrap();
    run!("{world} --force --seed 2").expect(3);
    assert_eq!(scratch.read("w.pref"), written);
    assert_eq!(names(&scratch.path("")), ["w.pref", "w.prism"]);
}

#[test]
fn export_keeps_what_is_no_part_of_a_dump() {
    let text = fs::read_to_string("models/toy.prism").unwrap();
    let scratch = Scratch::new(&[]);
    let dump = scratch.path("dump");
    let export = format!("export {TOY} --out {} -q", dump.display());
    run(&export).expect(0);
    run(&export).expect(0);
    fs::write(dump.join("m.prism"), &text).unwrap();
    let model = dump.join("m.prism");
    run!("export {} models/toy.pref --out {}", model.display(), dump.display()).ends(3, "`m.prism`");
    assert_eq!(fs::read_to_string(&model).unwrap(), text);
    let thesis = scratch.path("mine");
    fs::create_dir(&thesis).unwrap();
    fs::write(thesis.join("thesis.tex"), "years of work").unwrap();
    run!("export {TOY} --out {}", thesis.display()).expect(3);
    assert_eq!(names(&thesis), ["thesis.tex"]);
    assert_eq!(names(&scratch.path("")), ["dump", "mine"]);
}

#[test]
fn export_works_from_inside_through_links_and_as_the_umask_says() {
    let scratch = Scratch::new(&[]);
    let (here, root) = (scratch.show(""), env!("CARGO_MANIFEST_DIR"));
    let export = format!("$MELIORA export {root}/models/toy.prism {root}/models/toy.pref -q --out");
    shell(&format!("umask 027; {export} {here}/dump")).expect(0);
    assert_eq!((mode(&scratch.path("dump")), mode(&scratch.path("dump/manifest.json"))), (0o750, 0o640));
    fs::set_permissions(scratch.path("dump"), Permissions::from_mode(0o701)).unwrap();
    symlink("dump", scratch.path("link")).unwrap();
    for (folder, out) in
        [("dump", "../dump"), ("dump", "."), ("", "link"), ("", "link/"), ("", "dump/../dump")]
    {
        shell(&format!("cd {here}/{folder} && {export} {out}")).expect(0);
        assert_eq!(names(&scratch.path("")), ["dump", "link"], "{out}");
        assert_eq!(names(&scratch.path("dump")), ["certificate.dddmp", "manifest.json", "regions.dddmp"]);
        assert_eq!(mode(&scratch.path("dump")), 0o701);
    }
    run!("verify {} {TOY}", scratch.show("link")).expect(0);
}

#[test]
fn the_largest_size_of_a_file_is_a_limit_and_leaves_nothing_behind() {
    let scratch = Scratch::new(&[("page", "old")]);
    let here = scratch.show("");
    for command in [
        format!("export models/robot5x5.prism models/robot5x5.pref --out {here}/dump"),
        format!("report models/robot5x5.prism models/robot5x5.pref --out {here}/page"),
        format!("generate gridworld --rows 30 --cols 30 --out {here}/world"),
    ] {
        let finished = shell(&format!("ulimit -f 4; $MELIORA {command}")).expect(4);
        finished.says("could not be written");
        assert!(!finished.stderr.replace(&here, "").contains(".tmp"), "{}", finished.stderr);
        assert_eq!(names(&scratch.path("")), ["page"], "{command}");
        assert_eq!(scratch.read("page"), "old");
    }
}

/// Returns the files and folders below a folder, with their inodes and sizes.
fn tree(folder: &Path) -> Vec<(PathBuf, u64, u64)> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let Ok(data) = entry.metadata() else { continue };
        found.push((entry.path(), data.ino(), data.len()));
        if data.is_dir() {
            found.extend(tree(&entry.path()));
        }
    }
    found
}

#[test]
fn an_old_dump_is_there_until_the_new_one_is_whatever_happens() {
    let scratch = Scratch::new(&[]);
    let dump = scratch.path("dump");
    let arguments = format!("export {TOY} -q --out {}", dump.display());
    run(&arguments).expect(0);
    // Kills the command after some changes to the files: a new folder, files in it, the exchange.
    for limit in (0..12).cycle().take(36) {
        let mut command = Command::new(env!("CARGO_BIN_EXE_meliora"));
        command.args(arguments.split(' ')).current_dir(env!("CARGO_MANIFEST_DIR"));
        let (mut changes, mut before) = (0, tree(&scratch.path("")));
        let mut child = command.stderr(Stdio::piped()).spawn().unwrap();
        while changes < limit && child.try_wait().unwrap().is_none() {
            let now = tree(&scratch.path(""));
            changes += usize::from(now != before);
            before = now;
        }
        let _ = child.kill();
        let mut said = String::new();
        child.stderr.take().unwrap().read_to_string(&mut said).unwrap();
        child.wait().unwrap();
        let read = meliora::dump::read_directory(&dump, true, &meliora::engine::NoProgress);
        assert!(read.is_ok(), "killed after {changes} changes: {:?} {said}", read.err());
    }
}

#[test]
fn the_file_of_a_sweep_is_none_of_its_inputs() {
    let text =
        fs::read_to_string("models/toy.prism").unwrap().replace("module toy", "const int N; module toy");
    let preferences = fs::read_to_string("models/toy.pref").unwrap();
    let scratch = Scratch::new(&[("m.prism", &text), ("m.pref", &preferences)]);
    let sweep = format!("check {} {} -c N=1:2 --csv", scratch.show("m.prism"), scratch.show("m.pref"));
    for (out, status) in [("m.prism", 2), ("m.pref", 2), ("", 3), ("rows", 0), ("rows", 0)] {
        run!("{sweep} {}", scratch.show(out)).expect(status);
    }
    run!("{sweep} - --json").expect(2);
    let printed = run!("{sweep} -").expect(0).stdout;
    assert!(printed.starts_with("N,states,") && printed.lines().count() == 3, "{printed}");
    assert_eq!(scratch.read("m.prism"), text);
    assert_eq!(scratch.read("rows").lines().count(), 3);
    assert_eq!(names(&scratch.path("")), ["m.pref", "m.prism", "rows"]);
}

/// A manifest that named a file of the user as the drawing of a root made `export` delete it.
#[test]
fn an_export_deletes_no_file_that_it_did_not_write() {
    let scratch = Scratch::new(&[]);
    let export = || run!("export {TOY} --format dot --out {}", scratch.show("dump"));
    export().expect(0);
    export().expect(0);
    let [manifest, drawing] = ["manifest.json", "reachable.dot"].map(|name| scratch.path("dump").join(name));
    let [written, drawn] = [&manifest, &drawing].map(|path| std::fs::read_to_string(path).unwrap());
    let mine = scratch.path("dump").join("thesis.tex");
    for name in ["thesis.tex", "../dump/thesis.tex"] {
        std::fs::write(&mine, "years of work").unwrap();
        std::fs::write(&manifest, written.replace("\"reachable.dot\"", &format!("\"{name}\""))).unwrap();
        std::fs::remove_file(&drawing).ok();
        export().ends(3, "`thesis.tex`, which does not belong to the dump as it was written");
        assert_eq!(std::fs::read_to_string(&mine).unwrap(), "years of work");
    }
    std::fs::remove_file(&mine).unwrap();
    std::fs::write(&manifest, &written).unwrap();
    for (file, content) in [("reachable.dot", drawn.as_str()), ("regions.dddmp", "")] {
        let path = scratch.path("dump").join(file);
        let content = content.to_owned() + "mine";
        std::fs::write(&path, &content).unwrap();
        export().ends(3, "which does not belong to the dump as it was written");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), content);
        std::fs::write(&drawing, &drawn).unwrap();
    }
}

/// Opening them waited for a writer, without an end.
#[test]
fn a_named_pipe_next_to_transitions_is_refused_at_once() {
    for extension in ["sta", "lab"] {
        let scratch = Scratch::new(&[("m.tra", "2 2\n0 1 1\n1 1 1\n")]);
        let pipe = scratch.path(&format!("m.{extension}"));
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let refused = run!("info {} --timeout 20s", scratch.show("m.tra")).expect(3).stderr;
        let told = format!("{}: this is not a regular file", pipe.display());
        assert!(
            refused.contains("this is not a regular file") && refused.contains(&pipe.display().to_string()),
            "{told}: {refused}"
        );
    }
}
