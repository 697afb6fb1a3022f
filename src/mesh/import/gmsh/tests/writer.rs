//! A small writer of files: what the binary ones consist of, in either encoding.

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Form {
    Ascii,
    Little,
    Big,
    /// Little-endian with sizes of four bytes.
    Narrow,
}

pub(super) const FORMS: [Form; 4] = [Form::Ascii, Form::Little, Form::Big, Form::Narrow];

pub(super) struct Writer {
    pub bytes: Vec<u8>,
    form: Form,
    is_v4: bool,
}

impl Writer {
    pub fn new(form: Form, version: &str) -> Self {
        let mut writer = Self { bytes: Vec::new(), form, is_v4: version == "4.1" };
        let kind = if form == Form::Ascii { 0 } else { 1 };
        let size = if form == Form::Narrow && version == "4.1" { 4 } else { 8 };
        writer.text(&format!("$MeshFormat\n{version} {kind} {size}\n"));
        if form != Form::Ascii {
            writer.int(1);
            writer.text("\n");
        }
        writer.text("$EndMeshFormat\n");
        writer
    }

    pub fn is_ascii(&self) -> bool {
        self.form == Form::Ascii
    }

    pub fn text(&mut self, text: &str) -> &mut Self {
        self.bytes.extend_from_slice(text.as_bytes());
        self
    }

    fn put(&mut self, mut little: Vec<u8>, word: String) -> &mut Self {
        match self.form {
            Form::Ascii => return self.text(&format!("{word} ")),
            Form::Big => little.reverse(),
            Form::Little | Form::Narrow => {}
        }
        self.bytes.extend(little);
        self
    }

    pub fn int(&mut self, value: i32) -> &mut Self {
        self.put(value.to_le_bytes().into(), value.to_string())
    }

    pub fn ints(&mut self, values: &[i32]) -> &mut Self {
        values.iter().for_each(|value| {
            self.int(*value);
        });
        self
    }

    /// Numbers and counts, of the width that the version gives them.
    pub fn sizes(&mut self, values: &[u64]) -> &mut Self {
        for value in values {
            let is_wide = self.is_v4 && self.form != Form::Narrow;
            let bytes = value.to_le_bytes();
            let bytes = if is_wide { bytes.to_vec() } else { bytes[..4].to_vec() };
            self.put(bytes, value.to_string());
        }
        self
    }

    pub fn reals(&mut self, values: &[f64]) -> &mut Self {
        for value in values {
            self.put(value.to_le_bytes().into(), value.to_string());
        }
        self
    }

    /// The end of a record.
    pub fn end(&mut self) -> &mut Self {
        if self.is_ascii() {
            self.text("\n");
        }
        self
    }
}

/// A square of two triangles in MSH 4.1: `rock` and `all` both, a reversed line `bottom`, node
/// numbers with gaps, an orphan.
pub(super) fn square_v4(form: Form) -> Vec<u8> {
    let mut w = Writer::new(form, "4.1");
    w.text("$PhysicalNames\n3\n1 5 \"bottom\"\n2 5 \"rock\"\n2 6 \"all\"\n$EndPhysicalNames\n");
    w.text("$Entities\n").sizes(&[1, 1, 1, 0]).end();
    w.int(1).reals(&[0.0; 3]).sizes(&[0]).end();
    w.int(1).reals(&[0.0; 6]).sizes(&[1]).int(-5).sizes(&[2]).ints(&[1, -2]).end();
    w.int(7).reals(&[0.0; 6]).sizes(&[2]).ints(&[6, 5]).sizes(&[0]).end();
    w.text("\n$EndEntities\n$Nodes\n").sizes(&[3, 5, 10, 9000]).end();
    w.ints(&[0, 1, 0]).sizes(&[1]).end();
    w.sizes(&[10]).end().reals(&[0.0, 0.0, 0.0]).end();
    w.ints(&[1, 1, 1]).sizes(&[1]).end();
    w.sizes(&[20]).end().reals(&[1.0, 0.0, 0.0, 0.5]).end();
    w.ints(&[2, 7, 1]).sizes(&[3]).end();
    w.sizes(&[9000]).end().sizes(&[15]).end().sizes(&[40]).end();
    w.reals(&[1.0, 1.5, 0.0, 0.1, 0.2]).end();
    w.reals(&[7.0, 7.0, 7.0, 0.1, 0.2]).end();
    w.reals(&[0.0, 1.5, 0.0, 0.1, 0.2]).end();
    w.text("\n$EndNodes\n$Elements\n").sizes(&[2, 3, 100, 300]).end();
    w.ints(&[1, 1, 1]).sizes(&[1]).end();
    w.sizes(&[100, 10, 20]).end();
    w.ints(&[2, 7, 2]).sizes(&[2]).end();
    w.sizes(&[200, 10, 20, 9000]).end();
    w.sizes(&[300, 10, 9000, 40]).end();
    w.text("\n$EndElements\n");
    w.bytes
}

/// The same in MSH 2.2, its elements of two groups written twice.
pub(super) fn square_v2(form: Form) -> Vec<u8> {
    let mut w = Writer::new(form, "2.2");
    w.text("$PhysicalNames\n3\n1 5 \"bottom\"\n2 5 \"rock\"\n2 6 \"all\"\n$EndPhysicalNames\n");
    w.text("$Nodes\n5\n");
    w.sizes(&[10]).reals(&[0.0, 0.0, 0.0]).end();
    w.sizes(&[20]).reals(&[1.0, 0.0, 0.0]).end();
    w.sizes(&[9000]).reals(&[1.0, 1.5, 0.0]).end();
    w.sizes(&[15]).reals(&[7.0, 7.0, 7.0]).end();
    w.sizes(&[40]).reals(&[0.0, 1.5, 0.0]).end();
    w.text("\n$EndNodes\n$Elements\n5\n");
    if w.is_ascii() {
        w.text("100 1 2 5 1 20 10\n200 2 2 6 7 10 20 9000\n201 2 2 5 7 10 20 9000\n");
        w.text("300 2 2 6 7 10 9000 40\n301 2 2 5 7 10 9000 40\n");
    } else {
        w.ints(&[1, 1, 2, 100, 5, 1, 20, 10]);
        w.ints(&[2, 3, 2, 200, 6, 7, 10, 20, 9000, 201, 5, 7, 10, 20, 9000]);
        w.ints(&[300, 6, 7, 10, 9000, 40, 2, 1, 2, 301, 5, 7, 10, 9000, 40]);
    }
    w.text("\n$EndElements\n");
    w.bytes
}
