//! Formulas of a case file: `1e-4*(0.5+x)*t` as an expression tree in x, y, z and t.

use std::fmt::Write as _;

/// The names of the variables, in the order of [`Expression::Variable`].
const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];
/// Longest formula, in characters; it bounds the depth of left-leaning trees too.
const LONGEST: usize = 1000;
/// Deepest nesting of parentheses, functions, signs and powers.
const DEEPEST: usize = 64;

/// A parsed formula together with its text.
#[derive(Debug, Clone, PartialEq)]
pub struct Formula {
    text: String,
    root: Expression,
}

#[derive(Debug, Clone, PartialEq)]
enum Expression {
    Number(f64),
    Variable(usize),
    Negate(Box<Expression>),
    Binary(char, Box<Expression>, Box<Expression>),
    Call(Function, Vec<Expression>),
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Function {
    Sqrt,
    Exp,
    Ln,
    Sin,
    Cos,
    Abs,
    Step,
    Min,
    Max,
}

impl Function {
    const ALL: [(&str, Function); 9] = [
        ("sqrt", Function::Sqrt),
        ("exp", Function::Exp),
        ("ln", Function::Ln),
        ("sin", Function::Sin),
        ("cos", Function::Cos),
        ("abs", Function::Abs),
        ("step", Function::Step),
        ("min", Function::Min),
        ("max", Function::Max),
    ];

    fn takes_many(self) -> bool {
        matches!(self, Function::Min | Function::Max)
    }

    fn apply(self, arguments: impl Iterator<Item = f64>) -> f64 {
        // A NaN argument stays a NaN: f64::min would drop it.
        let fold = |pick: fn(f64, f64) -> bool| {
            move |a: f64, b: f64| if a.is_nan() || pick(a, b) { a } else { b }
        };
        let value = match self {
            Function::Min => return arguments.reduce(fold(|a, b| a < b)).unwrap_or(f64::NAN),
            Function::Max => return arguments.reduce(fold(|a, b| a > b)).unwrap_or(f64::NAN),
            _ => arguments.last().unwrap_or(f64::NAN),
        };
        match self {
            Function::Sqrt => value.sqrt(),
            Function::Exp => value.exp(),
            Function::Ln => value.ln(),
            Function::Sin => value.sin(),
            Function::Cos => value.cos(),
            Function::Step if value.is_nan() => value,
            Function::Step => truth(value >= 0.0),
            _ => value.abs(),
        }
    }
}

/// 1 for what holds, or 0.
fn truth(holds: bool) -> f64 {
    f64::from(u8::from(holds))
}

impl Expression {
    fn evaluate(&self, variables: &[f64; 4]) -> f64 {
        match self {
            Expression::Number(number) => *number,
            Expression::Variable(index) => variables[*index],
            Expression::Negate(inner) => -inner.evaluate(variables),
            Expression::Binary(operator, left, right) => {
                let (left, right) = (left.evaluate(variables), right.evaluate(variables));
                match operator {
                    '+' => left + right,
                    '-' => left - right,
                    '*' => left * right,
                    '/' => left / right,
                    '^' => left.powf(right),
                    _ if left.is_nan() || right.is_nan() => f64::NAN,
                    '<' => truth(left < right),
                    '>' => truth(left > right),
                    '≤' => truth(left <= right),
                    _ => truth(left >= right),
                }
            }
            Expression::Call(function, arguments) => {
                function.apply(arguments.iter().map(|argument| argument.evaluate(variables)))
            }
        }
    }

    fn uses(&self, wanted: &[usize]) -> bool {
        match self {
            Expression::Number(_) => false,
            Expression::Variable(index) => wanted.contains(index),
            Expression::Negate(inner) => inner.uses(wanted),
            Expression::Binary(_, left, right) => left.uses(wanted) || right.uses(wanted),
            Expression::Call(_, arguments) => arguments.iter().any(|a| a.uses(wanted)),
        }
    }
}

impl Formula {
    /// Reads a formula. `^` is right-associative and binds tighter than the sign before it;
    /// comparisons, of which there is one at a time, bind least and give 1 or 0.
    ///
    /// # Errors
    /// A sentence with the column (from 1) inside the formula.
    pub fn parse(text: &str) -> Result<Formula, String> {
        let characters: Vec<char> = text.chars().collect();
        if characters.len() > LONGEST {
            return Err(format!(
                "the formula has {} characters; at most {LONGEST} are read",
                characters.len()
            ));
        }
        let mut parser = Parser { characters, position: 0, depth: 0 };
        let root = parser.comparison()?;
        match parser.peek() {
            None => Ok(Formula { text: text.to_owned(), root }),
            Some(')') => Err(parser.complain("a closing parenthesis without an opening one")),
            Some(found) => Err(parser.complain(&format!("expected an operator before `{found}`"))),
        }
    }

    /// The formula with the opposite sign.
    pub(crate) fn negated(&self) -> Formula {
        let text = format!("-({})", self.text);
        Formula { text, root: Expression::Negate(Box::new(self.root.clone())) }
    }

    /// The value at a point and a time; not finite where the formula has none there.
    pub fn at(&self, point: [f64; 3], time: f64) -> f64 {
        self.root.evaluate(&[point[0], point[1], point[2], time])
    }

    /// Whether x, y or z occurs.
    pub fn varies_in_space(&self) -> bool {
        self.root.uses(&[0, 1, 2])
    }

    /// Whether y occurs, which a 2D case does not have.
    pub fn uses_y(&self) -> bool {
        self.root.uses(&[1])
    }

    /// Whether t occurs.
    pub fn uses_t(&self) -> bool {
        self.root.uses(&[3])
    }

    /// Whether no variable occurs.
    pub fn is_constant(&self) -> bool {
        !self.root.uses(&[0, 1, 2, 3])
    }

    /// The text it was read from.
    pub fn text(&self) -> &str {
        &self.text
    }
}

struct Parser {
    characters: Vec<char>,
    position: usize,
    depth: usize,
}

impl Parser {
    /// The next character that is no blank.
    fn peek(&mut self) -> Option<char> {
        while self.characters.get(self.position).is_some_and(|c| c.is_whitespace()) {
            self.position += 1;
        }
        self.characters.get(self.position).copied()
    }

    fn take(&mut self, wanted: char) -> bool {
        let found = self.peek() == Some(wanted);
        self.position += usize::from(found);
        found
    }

    fn complain(&self, what: &str) -> String {
        format!("{what} at column {} of the formula", self.position + 1)
    }

    fn comparison(&mut self) -> Result<Expression, String> {
        let left = self.sum()?;
        let Some(operator @ ('<' | '>' | '≤' | '≥')) = self.peek() else { return Ok(left) };
        self.position += 1;
        let with_equal = self.characters.get(self.position) == Some(&'=');
        self.position += usize::from(with_equal);
        let operator = match (operator, with_equal) {
            ('<', true) => '≤',
            ('>', true) => '≥',
            (other, _) => other,
        };
        Ok(Expression::Binary(operator, Box::new(left), Box::new(self.sum()?)))
    }

    fn sum(&mut self) -> Result<Expression, String> {
        let mut left = self.product()?;
        while let Some(operator @ ('+' | '-')) = self.peek() {
            self.position += 1;
            left = Expression::Binary(operator, Box::new(left), Box::new(self.product()?));
        }
        Ok(left)
    }

    fn product(&mut self) -> Result<Expression, String> {
        let mut left = self.signed()?;
        while let Some(operator @ ('*' | '/')) = self.peek() {
            self.position += 1;
            left = Expression::Binary(operator, Box::new(left), Box::new(self.signed()?));
        }
        Ok(left)
    }

    /// A power with any number of signs before it; every nested part passes here.
    fn signed(&mut self) -> Result<Expression, String> {
        if self.depth == DEEPEST {
            return Err(self.complain(&format!("more than {DEEPEST} nested parts")));
        }
        self.depth += 1;
        let result = if self.take('-') {
            self.signed().map(|inner| Expression::Negate(Box::new(inner)))
        } else if self.take('+') {
            self.signed()
        } else {
            self.power()
        };
        self.depth -= 1;
        result
    }

    fn power(&mut self) -> Result<Expression, String> {
        let base = self.atom()?;
        if self.take('^') {
            return Ok(Expression::Binary('^', Box::new(base), Box::new(self.signed()?)));
        }
        Ok(base)
    }

    fn atom(&mut self) -> Result<Expression, String> {
        match self.peek() {
            None => Err(self.complain("a number, a variable or `(` is missing")),
            Some('(') => {
                self.position += 1;
                let inner = self.comparison()?;
                self.close()?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_ascii_alphabetic() => self.name(),
            Some(c) => {
                Err(self.complain(&format!("expected a number, a variable or `(` but found `{c}`")))
            }
        }
    }

    fn close(&mut self) -> Result<(), String> {
        if self.take(')') { Ok(()) } else { Err(self.complain("`)` is missing")) }
    }

    fn number(&mut self) -> Result<Expression, String> {
        let start = self.position;
        let at = |position: usize| self.characters.get(position).copied();
        let digits = |mut end: usize| {
            while at(end).is_some_and(|c| c.is_ascii_digit()) {
                end += 1;
            }
            end
        };
        let mut end = digits(start);
        if at(end) == Some('.') {
            end = digits(end + 1);
        }
        if matches!(at(end), Some('e' | 'E')) {
            let sign = usize::from(matches!(at(end + 1), Some('+' | '-')));
            end = digits(end + 1 + sign);
        }
        let text: String = self.characters[start..end].iter().collect();
        match text.parse::<f64>() {
            Ok(number) if number.is_finite() => {
                self.position = end;
                Ok(Expression::Number(number))
            }
            _ => Err(self.complain(&format!("`{text}` is not a number"))),
        }
    }

    fn name(&mut self) -> Result<Expression, String> {
        let start = self.position;
        let end = self.characters[start..]
            .iter()
            .position(|c| !c.is_ascii_alphanumeric() && *c != '_')
            .map_or(self.characters.len(), |length| start + length);
        let name: String = self.characters[start..end].iter().collect();
        if name == "pi" {
            self.position = end;
            return Ok(Expression::Number(std::f64::consts::PI));
        }
        if let Some(index) = VARIABLES.iter().position(|variable| *variable == name) {
            self.position = end;
            return Ok(Expression::Variable(index));
        }
        let Some((_, function)) = Function::ALL.iter().find(|(known, _)| *known == name) else {
            let mut what = format!("unknown name `{name}` (known: x, y, z, t, pi");
            for (known, _) in Function::ALL {
                let _ = write!(what, ", {known}");
            }
            return Err(self.complain(&(what + ")")));
        };
        self.position = end;
        if !self.take('(') {
            return Err(self.complain(&format!("`(` is missing after `{name}`")));
        }
        let mut arguments = vec![self.comparison()?];
        while self.take(',') {
            arguments.push(self.comparison()?);
        }
        if function.takes_many() != (arguments.len() > 1) {
            let wanted = if function.takes_many() { "two or more" } else { "one" };
            return Err(self.complain(&format!("`{name}` takes {wanted} argument(s)")));
        }
        self.close()?;
        Ok(Expression::Call(*function, arguments))
    }
}

#[cfg(test)]
mod tests;
