//! The codes of the families, as the search of Olson (2011) found them.
//!
//! That search tries the numbers `first + n * 982451653` one after another, and keeps each that differs from all
//! kept ones in enough bits, in every rotation, and whose picture is complex enough. A table has the first code,
//! and the steps from each code to the next.
//!
//! The numbers come from the AprilTag library of the University of Michigan:
//!
//! BSD 2-Clause License
//!
//! Copyright (C) 2013-2016, The Regents of The University of Michigan.
//! All rights reserved.
//!
//! Redistribution and use in source and binary forms, with or without
//! modification, are permitted provided that the following conditions are met:
//!
//! 1. Redistributions of source code must retain the above copyright notice, this
//!    list of conditions and the following disclaimer.
//!
//! 2. Redistributions in binary form must reproduce the above copyright notice,
//!    this list of conditions and the following disclaimer in the documentation
//!    and/or other materials provided with the distribution.
//!
//! THIS SOFTWARE IS PROVIDED BY THE COPYRIGHT HOLDERS AND CONTRIBUTORS "AS IS"
//! AND ANY EXPRESS OR IMPLIED WARRANTIES, INCLUDING, BUT NOT LIMITED TO, THE
//! IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS FOR A PARTICULAR PURPOSE ARE
//! DISCLAIMED. IN NO EVENT SHALL THE COPYRIGHT HOLDER OR CONTRIBUTORS BE LIABLE
//! FOR ANY DIRECT, INDIRECT, INCIDENTAL, SPECIAL, EXEMPLARY, OR CONSEQUENTIAL
//! DAMAGES (INCLUDING, BUT NOT LIMITED TO, PROCUREMENT OF SUBSTITUTE GOODS OR
//! SERVICES; LOSS OF USE, DATA, OR PROFITS; OR BUSINESS INTERRUPTION) HOWEVER
//! CAUSED AND ON ANY THEORY OF LIABILITY, WHETHER IN CONTRACT, STRICT LIABILITY,
//! OR TORT (INCLUDING NEGLIGENCE OR OTHERWISE) ARISING IN ANY WAY OUT OF THE USE
//! OF THIS SOFTWARE, EVEN IF ADVISED OF THE POSSIBILITY OF SUCH DAMAGE.
//!
//! The views and conclusions contained in the software and documentation are those
//! of the authors and should not be interpreted as representing official policies,
//! either expressed or implied, of the Regents of The University of Michigan.

/// The distance of two candidates of the search: the fifty millionth prime.
const STRIDE: u64 = 982_451_653;

/// The codes of a family.
pub(crate) struct Codes {
    /// The first code: its bits row by row from the upper left, the first the most significant.
    first: u64,
    /// How many candidates each code is after the one before it.
    steps: &'static [u64],
}

impl Codes {
    /// Returns the codes, which have so many bits.
    pub(crate) fn all(self, bits: u32) -> impl Iterator<Item = u64> {
        let mask = u64::MAX >> (u64::BITS - bits);
        let advance = move |code: &mut u64, step: &u64| {
            *code = code.wrapping_add(step.wrapping_mul(STRIDE)) & mask;
            Some(*code)
        };
        std::iter::once(self.first).chain(self.steps.iter().scan(self.first, advance))
    }
}

#[rustfmt::skip] // A number a line would be 586 lines.
pub(crate) const TAG36H11: Codes = Codes {
    first: 0xd_5d62_8584,
    steps: &[
        1, 1, 2, 2, 2, 5, 3, 5, 1, 4, 3, 1, 1, 2, 1, 2, 4, 1, 5, 1, 1, 2, 5, 1, 3, 1, 2, 7, 1, 4, 20, 6,
        5, 4, 1, 1, 1, 8, 5, 4, 4, 6, 2, 3, 6, 8, 4, 2, 5, 15, 4, 2, 5, 10, 3, 19, 8, 16, 2, 6, 1, 1, 6,
        2, 3, 70, 8, 17, 15, 1, 6, 18, 19, 13, 7, 8, 3, 7, 31, 31, 7, 33, 31, 8, 19, 11, 22, 30, 45, 1,
        15, 9, 18, 13, 3, 20, 12, 42, 6, 2, 6, 83, 1, 5, 6, 55, 22, 16, 15, 37, 3, 8, 33, 27, 66, 46,
        16, 1, 184, 54, 96, 8, 32, 24, 17, 35, 25, 147, 47, 21, 35, 109, 16, 351, 30, 76, 134, 261, 49,
        48, 208, 57, 37, 274, 50, 125, 1, 28, 358, 39, 89, 39, 3, 37, 77, 22, 317, 337, 138, 302, 163,
        118, 4, 262, 53, 333, 452, 13, 48, 242, 163, 200, 850, 379, 399, 751, 201, 153, 280, 440, 564,
        119, 58, 36, 203, 144, 41, 29, 44, 1219, 559, 676, 736, 351, 264, 184, 418, 1248, 573, 244,
        1838, 453, 344, 463, 685, 1353, 1105, 1201, 485, 429, 1141, 440, 79, 1162, 2160, 1400, 1995,
        335, 559, 1853, 2075, 267, 736, 86, 464, 2206, 1332, 1268, 59, 862, 22, 6831, 1169, 1807, 7806,
        1454, 998, 3278, 1037, 1242, 4888, 4255, 2639, 4321, 13179, 7478, 415, 1861, 2692, 1749, 3417,
        1457, 4586, 760, 739, 1345, 1508, 2244, 471, 5947, 24719, 4588, 5184, 4403, 2968, 2214, 1098,
        1400, 2294, 26227, 447, 855, 3640, 195, 2671, 3766, 2465, 944, 1186, 5895, 6416, 7280, 5303,
        5917, 4473, 5519, 18548, 10280, 1245, 702, 13374, 32265, 3050, 1130, 14055, 238, 36585, 7564,
        4855, 17735, 968, 32040, 23380, 36165, 2096, 20320, 13044, 18259, 4142, 10019, 8166, 28278,
        53950, 11569, 101588, 24375, 29296, 9230, 8712, 21267, 3679, 34700, 4725, 12469, 15642, 72904,
        8170, 20568, 10682, 706, 9645, 5510, 1862, 19882, 56973, 19834, 70477, 70292, 38160, 29343,
        52923, 39373, 4290, 50082, 45979, 54879, 12245, 83805, 10710, 134683, 104823, 114263, 49481,
        42486, 24090, 34085, 153224, 149433, 1951, 42608, 53429, 142839, 254443, 159915, 3096, 44363,
        73859, 190892, 363064, 231088, 52500, 63973, 316404, 223350, 177913, 2241, 80323, 178377,
        796587, 760787, 189930, 1031972, 549646, 619700, 142657, 765819, 249619, 597447, 561307, 384970,
        324698, 202132, 224599, 945263, 965771, 1120475, 29872, 69335, 719422, 720934, 2208141, 364790,
        1130790, 1159704, 529480, 157048, 31610, 511216, 636068, 74252, 712059, 136899, 164934, 3524012,
        1828250, 545143, 455556, 6063766, 836387, 1824648, 269844, 1537892, 12705, 4000354, 166714,
        399941, 1934026, 70078, 120176, 975005, 452936, 562086, 468728, 1933928, 445648, 90540, 4296127,
        1588926, 4345265, 5733082, 5717244, 8213145, 3195523, 591096, 3914741, 3042312, 110972,
        10470660, 2251770, 2929017, 2789328, 19629458, 1565883, 1367418, 11359288, 1475453, 622573,
        14507975, 1960189, 952979, 2042971, 3836837, 4220171, 1424886, 10893025, 6662678, 24980399,
        10721977, 32596718, 928432, 6584154, 32640997, 23178460, 7949537, 3626550, 10210479, 17397558,
        5678652, 6868070, 4418658, 1087250, 5333223, 1968444, 20133775, 6802235, 29970970, 33730538,
        1109886, 1162991, 81608319, 4403740, 3445174, 2319188, 44630915, 70184233, 24161960, 13792492,
        8810916, 14923975, 31071471, 3620056, 24458198, 6647986, 24126956, 6912851, 7666038, 325929,
        2468426, 27784918, 44389320, 4836789, 1647515, 106139438, 30951296, 69234160, 24224217, 7197842,
        36236810, 96244967, 80651843, 49964004, 41307097, 10216495, 30976919, 56865865, 14058568,
        35671006, 31312751, 49138127, 14978724, 69777698, 138578340, 121750711, 116531764, 109920351,
        148560349, 83135564, 134258284, 69214854, 65419086, 77308280, 237603928, 20260811, 324087979,
        722515861, 471559342, 467863275, 62059969, 398214654, 96709872, 123559651, 44912569, 184107504,
        223441734, 313552974, 651630420, 78864866, 15004222, 165415206, 322951759, 488610954, 105573591,
        121969817, 156560961, 1351432330, 138276063, 2250400, 724415985, 2111588795, 297370447,
        465961629, 1336540463, 502299342, 317099293, 237944348, 2594059367, 516356637, 1507305122,
        854341365, 621902735, 9172901077, 95654740, 5669393179, 3638461780, 1666086249, 15030122520,
    ],
};

#[rustfmt::skip] // A number a line would be 34 lines.
pub(crate) const TAG25H9: Codes = Codes {
    first: 0x155_cbf1,
    steps: &[
        1, 10, 33, 13, 9, 47, 1, 12, 45, 275, 82, 137, 367, 357, 240, 1303, 3804, 3431, 1921, 9640,
        17071, 17454, 13959, 9147, 163096, 75041, 220091, 79665, 135966, 6132, 774557, 567693, 2503251,
        12326278,
    ],
};

#[rustfmt::skip] // A number a line would be 29 lines.
pub(crate) const TAG16H5: Codes = Codes {
    first: 0x231b,
    steps: &[
        2, 1, 3, 9, 1, 9, 9, 4, 4, 6, 32, 5, 10, 12, 6, 60, 24, 3, 28, 648, 198, 201, 543, 435, 157, 10,
        1693, 3026, 42004,
    ],
};
