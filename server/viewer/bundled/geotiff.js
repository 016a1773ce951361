// What the preview uses of geotiff.js.
export { fromBlob } from 'geotiff';
