# A named back end whose library cannot be loaded, or finds no driver, ends the program before anything is written;
# auto does without and says so.
qs-render --list-backends | grep -q 'without OpenGL' && { echo "this build draws without OpenGL"; exit 77; }
mkdir bogus
echo 'not a library' | tee bogus/libOSMesa.so.8 > bogus/libEGL.so.1
try() {
    LD_LIBRARY_PATH=bogus qs-render "$QS_DATA/bumpy.qs" --resolution 64,48 -o frame.ppm --backend "$@" 2>&1 | sed 's/so\.\([18]\): .* (Debian/so.\1: ... (Debian/'
    echo "exit ${PIPESTATUS[0]}"
    ls -A
}
try osmesa
try egl
try auto --verbose | sed 's/splatter, [^ ]*/splatter, .../'
rm frame.ppm
LD_LIBRARY_PATH=bogus qs-render --list-backends | sed 's/splatter, .*/splatter, .../; s/so\.\([18]\): .* (Debian/so.\1: ... (Debian/'
MESA_GL_VERSION_OVERRIDE=2.1 __EGL_VENDOR_LIBRARY_FILENAMES=none qs-render "$QS_DATA/bumpy.qs" --report no.jsonl --backend egl 2>&1 |
    grep -c '^qs-render: --backend egl: libEGL.so.1: .*; --list-backends says what there is$'
echo "exit ${PIPESTATUS[0]}"
ls -A
