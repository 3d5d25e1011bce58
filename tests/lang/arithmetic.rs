//! Numbers at the edges: as PRISM has them, or an error at its place; in both engines alike.

use meliora::model::value::Value;

use crate::common::prelude::*;

/// Returns the value of a constant, or the error message and the text that it points at.
fn constant(ty: &str, expression: &str) -> Result<Value, (String, String)> {
    let source = SourceFile::new("m", format!("mdp const {ty} k = {expression}; module m x:bool; endmodule"));
    match lang::load(&source, &SourceFile::new("c", "")) {
        Ok(checked) => Ok(checked.program.constants[0].1.rounded()),
        Err(Error::Input(wrong)) => {
            let first = &wrong[0];
            let label = &first.label;
            Err((format!("{}: {label}", first.message), source.text[first.span.clone()].to_owned()))
        }
        Err(other) => panic!("{other}"),
    }
}

#[test]
fn integers_are_exact_up_to_64_bits() {
    for (expression, value) in [
        ("9223372036854775806+1", i64::MAX),
        ("-9223372036854775807-1", i64::MIN),
        ("-pow(2,62)*2", i64::MIN),
        ("pow(-2,63)", i64::MIN),
        ("pow(0,0)", 1),
        ("pow(1,9223372036854775807)", 1),
        ("pow(-1,9223372036854775807)", -1),
        ("mod(-5,3)", 1),
        ("mod(-9223372036854775807-1,9223372036854775807)", i64::MAX - 1),
        ("floor(-0.5)", -1),
        ("ceil(-0.5)", 0),
        ("round(-0.5)", 0),
        ("round(2.5)", 3),
        ("round(-2.5)", -2),
        ("round(0.49999999999999994)", 0),
        ("round(4503599627370497.0)", 4_503_599_627_370_497),
        ("floor(7/2)", 3),
    ] {
        assert_eq!(constant("int", expression), Ok(Value::Int(value)), "{expression}");
    }
}

#[test]
fn what_does_not_fit_is_an_error_at_its_place() {
    for (expression, place, reason) in [
        ("1+(9223372036854775807+1)", "9223372036854775807+1", "64-bit"),
        ("-9223372036854775807-2", "-9223372036854775807-2", "64-bit"),
        ("-(-9223372036854775807-1)", "-(-9223372036854775807-1)", "64-bit"),
        ("9223372036854775807*2", "9223372036854775807*2", "64-bit"),
        ("pow(2,63)", "pow(2,63)", "64-bit"),
        ("pow(2,-1)", "pow(2,-1)", "not negative"),
        ("mod(5,0)", "mod(5,0)", "zero"),
        ("mod(5,-3)", "mod(5,-3)", "positive"),
        ("floor(1e19)", "floor(1e19)", "integer"),
        ("ceil(1/0)", "ceil(1/0)", "finite"),
        ("round(log(-1,2))", "round(log(-1,2))", "finite"),
        ("9223372036854775808", "9223372036854775808", "64 bits"),
    ] {
        let (message, at) = constant("int", expression).expect_err(expression);
        assert!(message.contains(reason), "{expression}: {message}");
        assert_eq!(at, place, "{expression}: {message}");
    }
}

#[test]
fn constants_may_be_infinite_or_no_number_as_in_prism() {
    for (expression, value) in [
        ("1/0", f64::INFINITY),
        ("-1/0", f64::NEG_INFINITY),
        ("log(0,2)", f64::NEG_INFINITY),
        ("pow(0.0,-1)", f64::INFINITY),
        ("1e300*1e300", f64::INFINITY),
    ] {
        assert_eq!(constant("double", expression), Ok(Value::Real(value)), "{expression}");
    }
    for expression in ["0/0", "log(8,1)", "log(8,0)", "log(8,-2)", "pow(-8.0,0.5)"] {
        let value = constant("double", expression);
        assert!(matches!(value, Ok(Value::Real(x)) if x.is_nan()), "{expression}: {value:?}");
    }
    assert!(constant("double", "1e309").is_err());
}

#[test]
fn reals_are_those_of_prism() {
    for (expression, value) in [
        ("log(8,2)", 3.0),
        ("pow(2.0,-1)", 0.5),
        ("1/2", 0.5),
        ("min(0.5,1)", 0.5),
        // Where nothing is a number, C and Rust would say 1.
        ("(pow(1.0,1/0) = pow(1.0,1/0)) ? 1 : 2", 2.0),
        ("(min(1.0,0/0) = min(1.0,0/0)) ? 1 : 2", 2.0),
        ("(0/0 < 1 | 0/0 >= 1) ? 1 : 2", 2.0),
        // There is one zero.
        ("1/max(-0.0,0.0) > 0 ? 1 : 2", 1.0),
        ("1/min(0.0,-0.0) > 0 ? 1 : 2", 1.0),
        ("log(1000,10)", 3.0),
        ("(0.1+0.2 = 0.3) ? 1 : 2", 1.0),
    ] {
        assert_eq!(constant("double", expression).map(Value::to_f64), Ok(value), "{expression}");
    }
}

fn program(text: &str) -> Arc<Program> {
    Arc::new(parsed(text))
}

/// Returns the first error message of each engine for a model; none if the engine accepts it.
fn said(text: &str) -> [Option<String>; 2] {
    let program = program(text);
    let settings = Settings { scope: Scope::All, memory: 64 << 20, ..Settings::default() };
    let explicit = ExplicitEngine::new(program.clone(), settings.clone()).err();
    let symbolic = SymbolicEngine::new(program.clone(), settings).err();
    [explicit, symbolic].map(|error| error.map(|e| e.to_string()))
}

#[test]
fn probabilities_that_are_none_are_refused_by_both_engines_with_the_same_words() {
    for (first, second, shown) in [
        ("0/0", "0", "NaN"),
        ("1/x", "1-1/x", "inf"),
        ("x-1", "2-x", "-1"),
        ("0.5", "0.4", "0.9"),
        ("log(x-1,2)", "1", "NaN"),
        ("2", "-1", "2"),
    ] {
        let text = format!("mdp module m x:[0..1]; [] true -> {first}:(x'=0) + {second}:(x'=1); endmodule");
        let [explicit, symbolic] = said(&text);
        let message = explicit.clone().unwrap_or_else(|| panic!("{text}"));
        assert!(message.contains(&format!("give {shown} in")), "{message}");
        assert_eq!(explicit, symbolic, "{text}");
    }
}

#[test]
fn an_update_or_a_guard_without_a_value_is_refused_by_both_engines_with_the_same_words() {
    for (guard, update) in [
        ("true", "mod(7,x)"),
        ("true", "x*9223372036854775807*2"),
        ("pow(2,63*x)>0", "x"),
        ("true", "pow(2,x-1)"),
        ("true", "floor(1/x)"),
        ("mod(3,x)=0", "x"),
        ("true", "-(x*9223372036854775807+x)+x"),
        ("x=0 | log(x,1)>0 | mod(x,x-1)=0", "x"),
    ] {
        let text = format!("mdp module m x:[0..1]; [] {guard} -> (x'={update}); endmodule");
        let [explicit, symbolic] = said(&text);
        assert!(explicit.is_some(), "{text}");
        assert_eq!(explicit, symbolic, "{text}");
    }
}

#[test]
fn what_is_not_evaluated_may_have_no_value() {
    for guard in ["x=0 | mod(3,x)=0", "x>0 & mod(3,x)=0", "(x=0 ? 1 : mod(3,x))=0", "x>0 => mod(3,x)=0"] {
        let text = format!("mdp module m x:[0..1]; [] {guard} -> true; endmodule");
        assert_eq!(said(&text), [None, None], "{text}");
    }
}

/// Expressions over the constant N = 0, none of which is ever evaluated where it has no value.
const GUARDED: &[&str] = &[
    "(N=0 ? 0 : mod(x,N))=0",
    "(N>0 ? pow(2,N-1) : x)=0",
    "(N=0 ? 1 : mod(7,N)) > 0",
    "N>0 & mod(x,N)=0",
    "x>0 & N>0 & mod(x,N)=0 & x<1",
    "x+1>0 & N>0 & x<1 & pow(2,N-1)=0",
    "N=0 | mod(x,N)=0",
    "x=0 | N=0 | mod(x,N)=0",
    "N>0 => mod(x,N)=0",
    "x>0 & N>0 => mod(x,N)=0",
    "!(x>0 & N>0) | mod(x,N)=0",
    "(x>0 & N>0 ? mod(x,N) : 1) = 1",
    "(N>0 & x>0 ? 9223372036854775807*(2-N) : x) = x",
    "(N=1 ? mod(x,N) : N=2 ? mod(x,-N) : 5) = 5",
];

#[test]
fn what_constants_keep_from_being_evaluated_may_have_no_value() {
    for guarded in GUARDED {
        let constant = guarded.replace('x', "N");
        let text = format!(
            "mdp const int N=0; const bool k = {constant}; formula f = {guarded}; label \"l\" = {guarded};\n\
             module m x:[0..({constant}) ? 1 : 2]; [] {guarded} -> (f ? 0.5 : 1):(x'=f ? 0 : 1) + (f ? 0.5 : 0):true; endmodule"
        );
        assert_eq!(said(&text), [None, None], "{text}");
    }
}

#[test]
fn a_formula_that_has_no_value_is_wrong_where_it_is_evaluated() {
    let model = |guard: &str| {
        let text = format!(
            "mdp const int N=0; formula f = mod(x,N); module m x:[0..1]; [] {guard} -> true; endmodule"
        );
        let source = SourceFile::new("m", text);
        let loaded = lang::load(&source, &SourceFile::new("c", ""));
        loaded.map_err(|e| match e {
            Error::Input(wrong) => (wrong[0].label.clone(), source.text[wrong[0].span.clone()].to_owned()),
            other => panic!("{other}"),
        })
    };
    assert!(model("true").is_ok());
    assert!(model("N>0 & f=0").is_ok());
    for guard in ["f=0", "x=0 | f=0", "(x=0 ? 0 : f)=0", "N=0 & f=0", "x>0 & f=0 & N>0"] {
        let (label, place) = model(guard).map(|_| ()).expect_err(guard);
        assert_eq!((label.as_str(), place.as_str()), ("division by zero in `mod`", "mod(x,N)"), "{guard}");
    }
}

#[test]
fn a_type_is_wrong_also_where_nothing_is_evaluated() {
    for expression in ["true ? 0 : mod(1.5,2)", "true ? 0 : true", "(false & 1) ? 0 : 1"] {
        let (message, _) = constant("int", expression).expect_err(expression);
        assert!(message.contains("type error"), "{expression}: {message}");
    }
}

#[test]
fn a_target_without_a_value_in_any_state_is_refused() {
    let program = parsed("mdp const int N=0; module m x:[0..1]; endmodule");
    let target = |text: &str| {
        let source = SourceFile::new("t", text);
        lang::lower_target(&program, &source, &lang::parse_expression(&source).unwrap()).is_ok()
    };
    assert!(target("N>0 & mod(x,N)=0"));
    assert!(!target("x=0 | mod(x,N)=0"));
}
